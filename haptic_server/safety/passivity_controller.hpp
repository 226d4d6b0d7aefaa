#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "haptic_server/safety/energy_observer.hpp"
#include "haptic_server/safety/safety_flag.hpp"

namespace stillgrid::safety {

/// Takes back the energy that a held force has given and no scene has, by a damper on the device's
/// own motion.
///
/// Where E = -(given_J - given by scenes) < 0, the damper alpha = -E / (T v^2) would take it back
/// within one tick
/// [Hannaford and Ryu 2002; docs/cases.md, case 1.8], v being the motion of the tick gone by.
/// A slow tick makes that alpha endless and the loop diverge; so it is at most m / T, which stops
/// the mass m in a tick and does not throw it back. docs/algorithms/passivity.md: what that buys.
/// Thread: the haptic loop's. Realtime: yes.
class PassivityController {
 public:
  /// mass_kg: apparent, of the device with the hand; finite, > 0.
  explicit PassivityController(double mass_kg) : mass_kg_(mass_kg) {}

  /// The force to add to the rendered one. Sets kFlagPassivity if it is not zero.
  ///
  /// account: observed up to this tick. given_by_scenes_J: of it, by what moves
  /// (InterfaceAccount); 0: not known. motion: of the tick gone by. Books what the force added in
  /// the tick before has dissipated; the stages after this one may have shortened that force, and
  /// with a delay or a saturated motor the user felt another. Pre: tick_s > 0.
  [[nodiscard]] Eigen::Vector3d damp(HandEnergy& account, double given_by_scenes_J,
                                     const DeviceMotion& motion, double tick_s,
                                     std::uint32_t& flags) noexcept;

 private:
  double mass_kg_;
  Eigen::Vector3d added_N_ = Eigen::Vector3d::Zero();  // in the tick before
};

}  // namespace stillgrid::safety
