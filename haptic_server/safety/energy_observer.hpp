#pragma once

#include <Eigen/Core>

#include "haptic_server/safety/wrench.hpp"

namespace stillgrid::safety {

/// How the device moved in a tick: of the tool's origin in the device's own scale, and the rotation
/// about it as axis times angle; both in the axes of the forces. Zero where it is not known.
struct DeviceMotion {
  Eigen::Vector3d moved_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d turned_rad = Eigen::Vector3d::Zero();
};

/// Energy that crossed from the device to the user since the loop began, J.
struct HandEnergy {
  double given_J = 0.0;       // what springs still hold is negative here
  double most_given_J = 0.0;  // the most it ever was; over static bodies more than zero is a leak
  double dissipated_by_control_J = 0.0;
};

/// Work of a held force and torque over a motion, J.
[[nodiscard]] double work_J(const Wrench& held, const DeviceMotion& motion) noexcept;

/// Books the work of the force that was held from the tick before to this one.
///
/// held: what the device was told in the tick before, NOT what it is about to be told. Where a
/// spring is pressed and let go, the product with the new force is wrong by the whole leak of the
/// hold and of the other sign: it never shows one (docs/algorithms/passivity.md). Realtime: yes.
void observe(HandEnergy& account, const Wrench& held, const DeviceMotion& motion) noexcept;

}  // namespace stillgrid::safety
