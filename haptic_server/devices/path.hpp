#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>

#include "haptic_server/devices/trajectory_curve.hpp"

namespace stillgrid::devices {

/// How the hand means to move. z points up.
enum class PathKind {
  kStill,     // stays at the centre
  kPress,     // down by the depth and up again, once a period
  kStroke,    // down within half a period, then to and fro along x
  kTap,       // a short dip in the first quarter of each period, waiting at the centre between
  kCircle,    // down within half a period, then circles in the horizontal plane
  kRecorded,  // follows a curve, then stays at its end
};

/// The motion a hand intends, in the device's frame. The defaults press from 3 cm above the
/// plane z = 0 to 1 cm below it.
///
/// The generated paths start at the centre at rest, and their velocity is continuous.
struct Path {
  PathKind kind = PathKind::kPress;
  Eigen::Vector3d centre_m = Eigen::Vector3d(0.0, 0.0, 0.03);
  double depth_m = 0.04;       // below the centre
  double amplitude_m = 0.025;  // of the stroke; radius of the circle; reached in one period
  double period_s = 2.0;       // > 0
  TrajectoryCurve recorded;    // of kRecorded
};

/// The generator of that name: still, press, stroke, tap or circle.
[[nodiscard]] std::optional<PathKind> path_kind(std::string_view name) noexcept;

/// Where the path is at time_s, and its exact derivative. At rest at its start before zero.
///
/// Realtime: never allocates, locks or throws; O(log knots) for a recorded path.
/// Pre: period_s > 0; a recorded path has a knot; time_s is not NaN.
[[nodiscard]] MotionPoint path_at(const Path& path, double time_s) noexcept;

}  // namespace stillgrid::devices
