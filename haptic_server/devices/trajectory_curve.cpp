#include "haptic_server/devices/trajectory_curve.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

#include "haptic_server/devices/band_limit.hpp"

namespace stillgrid::devices {
namespace {

constexpr double kLongestStale_s = 0.05;  // a sensor slower than 20 Hz is taken for a rest

/// The rows that are not stale readings, see make_curve().
std::vector<std::size_t> fresh_rows(const tables::Trajectory& trajectory) {
  std::vector<std::size_t> rows;
  const std::size_t count = trajectory.time_s.size();
  for (std::size_t first = 0; first < count;) {
    std::size_t end = first + 1;
    while (end < count && trajectory.position_m[end] == trajectory.position_m[first]) ++end;
    const double standing_s = trajectory.time_s[end - 1] - trajectory.time_s[first];
    const std::size_t kept_end = standing_s > kLongestStale_s ? end : first + 1;
    for (std::size_t row = first; row < kept_end; ++row) rows.push_back(row);
    first = end;
  }
  if (rows.back() != count - 1) rows.push_back(count - 1);
  return rows;
}

std::vector<std::size_t> thinned(const std::vector<std::size_t>& rows,
                                 const tables::Trajectory& trajectory, double spacing_s) {
  std::vector<std::size_t> kept;
  for (const std::size_t row : rows) {
    const bool is_last = row == rows.back();
    const bool is_near =
        !kept.empty() && trajectory.time_s[row] - trajectory.time_s[kept.back()] < spacing_s;
    if (is_near && !is_last) continue;
    if (is_near && kept.size() > 1) kept.pop_back();  // the last row takes its neighbour's place
    kept.push_back(row);
  }
  return kept;
}

/// The second derivatives at the knots of the natural cubic spline.
///
/// Continuity of the first derivative at knot i, with steps h and slopes d, reads
///   h[i-1] a[i-1] + 2 (h[i-1] + h[i]) a[i] + h[i] a[i+1] = 6 (d[i] - d[i-1]).
/// The matrix is diagonally dominant whatever the steps, so elimination needs no pivots.
std::vector<Eigen::Vector3d> spline_accelerations(const std::vector<double>& time_s,
                                                  const std::vector<Eigen::Vector3d>& position_m) {
  const std::size_t count = time_s.size();
  std::vector<Eigen::Vector3d> acceleration(count, Eigen::Vector3d::Zero());
  if (count < 3) return acceleration;

  const auto step = [&](std::size_t i) { return time_s[i + 1] - time_s[i]; };
  const auto slope = [&](std::size_t i) -> Eigen::Vector3d {
    return (position_m[i + 1] - position_m[i]) / step(i);
  };
  std::vector<double> upper(count, 0.0);
  for (std::size_t i = 1; i + 1 < count; ++i) {
    const double pivot = 2.0 * (step(i - 1) + step(i)) - step(i - 1) * upper[i - 1];
    upper[i] = step(i) / pivot;
    acceleration[i] = (6.0 * (slope(i) - slope(i - 1)) - step(i - 1) * acceleration[i - 1]) / pivot;
  }
  for (std::size_t i = count - 2; i > 0; --i) acceleration[i] -= upper[i] * acceleration[i + 1];
  return acceleration;
}

/// The interval that holds time_s: times[i] <= time_s < times[i + 1].
/// Pre: times.front() <= time_s < times.back().
std::size_t interval_of(const std::vector<double>& times, double time_s,
                        std::size_t hint) noexcept {
  constexpr std::size_t kWalk = 8;  // a tick seldom passes more rows; then search
  const auto holds = [&](std::size_t i) { return times[i] <= time_s && time_s < times[i + 1]; };
  for (std::size_t i = hint; i + 1 < times.size() && i < hint + kWalk; ++i) {
    if (holds(i)) return i;
  }
  const auto after = std::upper_bound(times.begin(), times.end(), time_s);
  return static_cast<std::size_t>(after - times.begin()) - 1;
}

}  // namespace

TrajectoryCurve spline_through(std::vector<double> time_s,
                               std::vector<Eigen::Vector3d> position_m) {
  TrajectoryCurve curve;
  curve.knot_acceleration_m_s2 = spline_accelerations(time_s, position_m);
  curve.knot_time_s = std::move(time_s);
  curve.knot_position_m = std::move(position_m);
  return curve;
}

TrajectoryCurve make_curve(const tables::Trajectory& trajectory, Resampling resampling,
                           double knot_spacing_s, double tick_s) {
  assert(!trajectory.time_s.empty() && knot_spacing_s >= 0.0);
  TrajectoryCurve curve;
  if (resampling == Resampling::kLinear) {
    curve.knot_time_s = trajectory.time_s;
    curve.knot_position_m = trajectory.position_m;
    curve.knot_acceleration_m_s2.assign(curve.knot_time_s.size(), Eigen::Vector3d::Zero());
  } else {
    std::vector<double> time_s;
    std::vector<Eigen::Vector3d> position_m;
    for (const std::size_t row : thinned(fresh_rows(trajectory), trajectory, knot_spacing_s)) {
      time_s.push_back(trajectory.time_s[row]);
      position_m.push_back(trajectory.position_m[row]);
    }
    curve = spline_through(std::move(time_s), std::move(position_m));
    if (resampling == Resampling::kBandLimited) curve = band_limited(curve, tick_s);
  }
  if (!trajectory.orientation.empty()) {
    curve.row_time_s = trajectory.time_s;
    curve.orientation = trajectory.orientation;
  }
  return curve;
}

MotionPoint curve_at(const TrajectoryCurve& curve, double time_s, CurveCursor& cursor) noexcept {
  if (time_s < curve.knot_time_s.front()) return {curve.knot_position_m.front(), {0.0, 0.0, 0.0}};
  if (time_s >= curve.knot_time_s.back()) return {curve.knot_position_m.back(), {0.0, 0.0, 0.0}};
  const std::size_t i = interval_of(curve.knot_time_s, time_s, cursor.knot);
  cursor.knot = i;

  const double step_s = curve.knot_time_s[i + 1] - curve.knot_time_s[i];
  const double right = (time_s - curve.knot_time_s[i]) / step_s;
  const double left = 1.0 - right;
  const Eigen::Vector3d& from_m = curve.knot_position_m[i];
  const Eigen::Vector3d& to_m = curve.knot_position_m[i + 1];
  const Eigen::Vector3d& from_m_s2 = curve.knot_acceleration_m_s2[i];
  const Eigen::Vector3d& to_m_s2 = curve.knot_acceleration_m_s2[i + 1];
  const double left_bend_s2 = (left * left - 1.0) * left * step_s * step_s / 6.0;
  const double right_bend_s2 = (right * right - 1.0) * right * step_s * step_s / 6.0;
  return {left * from_m + right * to_m + left_bend_s2 * from_m_s2 + right_bend_s2 * to_m_s2,
          (to_m - from_m) / step_s + (3.0 * right * right - 1.0) * step_s / 6.0 * to_m_s2 -
              (3.0 * left * left - 1.0) * step_s / 6.0 * from_m_s2};
}

Eigen::Quaterniond orientation_at(const TrajectoryCurve& curve, double time_s,
                                  CurveCursor& cursor) noexcept {
  assert(!curve.orientation.empty());
  if (time_s < curve.row_time_s.front()) return curve.orientation.front();
  if (time_s >= curve.row_time_s.back()) return curve.orientation.back();
  const std::size_t i = interval_of(curve.row_time_s, time_s, cursor.row);
  cursor.row = i;
  const double fraction =
      (time_s - curve.row_time_s[i]) / (curve.row_time_s[i + 1] - curve.row_time_s[i]);
  return curve.orientation[i].slerp(fraction, curve.orientation[i + 1]).normalized();
}

}  // namespace stillgrid::devices
