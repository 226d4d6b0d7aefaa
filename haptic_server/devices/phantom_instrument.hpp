#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

#include "haptic_server/devices/path.hpp"

namespace stillgrid::devices {

/// The nearest that a path may bring the handle of an instrument to its pivot.
inline constexpr double kLeastInstrument_m = 0.02;

/// Where a rigid instrument is whose shaft passes through a fixed point, a trocar: its handle in
/// one frame with the pivot, the unit vector from the handle to the pivot and how far that is.
/// A tool's shaft lies along its -z, the handle at its origin.
struct Instrument {
  Eigen::Vector3d handle_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d shaft = -Eigen::Vector3d::UnitZ();
  double distance_m = 0.0;
};

/// The instrument held at handle_m. At the pivot itself it keeps the shaft of `before`.
/// Realtime: never allocates, locks or throws. Pre: finite.
[[nodiscard]] Instrument place_instrument(const Instrument& before, const Eigen::Vector3d& handle_m,
                                          const Eigen::Vector3d& pivot_m) noexcept;

/// The orientation of the tool: the shortest rotation from -z to the shaft, which has no roll of
/// its own. It is continuous wherever the shaft does not point straight up, where it is half a turn
/// about x.
/// Realtime: as place_instrument().
[[nodiscard]] Eigen::Quaterniond orientation_of(const Instrument& instrument) noexcept;

/// The force at the handle of a force and a torque about the handle that the scene exerts on the
/// instrument: what a hand feels that holds the handle as a ball joint.
///
/// It is the one force that does their work in every motion of the handle:
///   F + u x (T - e (u . T) / (1 + e . u)) / d
/// with u the shaft, d the distance, e = -z: what is added is the trocar's force, across the
/// shaft, so that neither it nor the roll which follows the shaft takes any work. A lateral force
/// at a distance a from the handle comes out times (d - a) / d, reversed beyond the pivot. Nearer
/// to the pivot than kLeastInstrument_m the levers are those at that distance.
/// What is not finite comes out so. Realtime: as place_instrument().
[[nodiscard]] Eigen::Vector3d force_at_handle_N(const Instrument& instrument,
                                                const Eigen::Vector3d& force_N,
                                                const Eigen::Vector3d& torque_N_m) noexcept;

/// Whether a handle there holds an instrument: not nearer to the pivot than kLeastInstrument_m, nor
/// below it, where a shaft may point straight up. What is no number does not.
[[nodiscard]] bool holds_instrument(const Eigen::Vector3d& handle_m,
                                    const Eigen::Vector3d& pivot_m) noexcept;

/// A point of a path that holds no instrument, or nothing. A generated path is looked at in
/// thousandths of its period, a recorded one in eighths of the way from knot to knot.
/// Pre: as path_at().
[[nodiscard]] std::optional<Eigen::Vector3d> unfit_point_m(const Path& path,
                                                           const Eigen::Vector3d& pivot_m);

}  // namespace stillgrid::devices
