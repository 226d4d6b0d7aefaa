#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "shared/tables/trajectory.hpp"

namespace stillgrid::devices {

/// How a recording is evaluated between its samples.
enum class Resampling {
  kLinear,       // velocity steps at every sample
  kCubic,        // natural cubic spline: position, velocity and acceleration are continuous
  kBandLimited,  // the cubic, low-passed for its samples and for the ticks, see band_limit.hpp
};

/// A trajectory made ready to be evaluated at any time: a piecewise cubic through its knots.
///
/// Invariants: at least one knot; times grow strictly; the arrays of a group are as long as
/// each other.
struct TrajectoryCurve {
  std::vector<double> knot_time_s;
  std::vector<Eigen::Vector3d> knot_position_m;
  std::vector<Eigen::Vector3d> knot_acceleration_m_s2;  // zero everywhere: linear
  std::vector<double> row_time_s;                       // of orientation
  std::vector<Eigen::Quaterniond> orientation;          // empty when not recorded
};

/// Where the curve was read last; makes reading in order of time cost O(1). Start at zero.
struct CurveCursor {
  std::size_t knot = 0;
  std::size_t row = 0;
};

/// Where something is, and how fast it moves.
struct MotionPoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
};

/// The natural cubic spline through these points, without orientations.
///
/// Pre: at least one point; as many times as positions; times grow strictly.
[[nodiscard]] TrajectoryCurve spline_through(std::vector<double> time_s,
                                             std::vector<Eigen::Vector3d> position_m);

/// Chooses the knots and solves for the spline.
///
/// Linear takes every sample as a knot. Cubic passes through every sample but two kinds, and
/// band-limited begins with the cubic:
///   - stale readings, rows that repeat the position above them for no longer than 50 ms in
///     all. A logger faster than its sensor writes them; a spline through them would swing
///     between standing and leaping. A longer run of repeats is a rest: all its rows stay.
///   - samples nearer than knot_spacing_s to the knot before. Zero keeps them all. A
///     recording whose pose was interpolated linearly from a slow sensor needs the sensor's
///     period here (0.035 s at 28.6 Hz), or the spline follows the corners.
/// The last sample is always a knot.
/// tick_s is of the loop that will read it; only band-limited needs it.
/// Pre: the invariants of Trajectory; knot_spacing_s >= 0; tick_s > 0.
[[nodiscard]] TrajectoryCurve make_curve(const tables::Trajectory& trajectory,
                                         Resampling resampling, double knot_spacing_s = 0.0,
                                         double tick_s = 1e-3);

/// Position and velocity at time_s after the first sample; before the first knot and after
/// the last one the curve stands still.
///
/// Realtime: never allocates, locks or throws; O(1) when times come in order, O(log knots)
/// otherwise. Pre: the invariants of TrajectoryCurve; time_s is not NaN.
[[nodiscard]] MotionPoint curve_at(const TrajectoryCurve& curve, double time_s,
                                   CurveCursor& cursor) noexcept;

/// Orientation at time_s, on the great circle between the neighbouring rows, the short way.
///
/// Realtime: as curve_at(). Pre: orientation is not empty; time_s is not NaN.
[[nodiscard]] Eigen::Quaterniond orientation_at(const TrajectoryCurve& curve, double time_s,
                                                CurveCursor& cursor) noexcept;

}  // namespace stillgrid::devices
