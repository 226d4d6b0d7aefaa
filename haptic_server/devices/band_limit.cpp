#include "haptic_server/devices/band_limit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

namespace stillgrid::devices {
namespace {

// A Blackman window over so many zeros of the sinc to either side blurs its edge by 0.17 of the
// cut-off to either side [-74 dB]: cut at 0.85 f, it passes 0.7 f and stops f.
constexpr double kZeros = 16.0;
constexpr double kCutoff = 0.85;

/// The weights of samples step_s apart, from the middle outwards; with their mirror image they
/// sum to one.
std::vector<double> low_pass_weights(double cutoff_hz, double step_s) {
  const double half_width_s = 0.5 * kZeros / cutoff_hz;
  std::vector<double> weights = {1.0};
  double sum = 1.0;
  for (int n = 1; n * step_s < half_width_s; ++n) {
    const double time_s = n * step_s;
    const double turn = 2.0 * std::numbers::pi * cutoff_hz * time_s;
    const double window_turn = std::numbers::pi * time_s / half_width_s;
    const double window = 0.42 + 0.5 * std::cos(window_turn) + 0.08 * std::cos(2.0 * window_turn);
    weights.push_back(window * std::sin(turn) / turn);
    sum += 2.0 * weights.back();
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

/// The curve, continued beyond its ends as a point reflection in them.
Eigen::Vector3d continued_m(const TrajectoryCurve& curve, double time_s, CurveCursor& cursor) {
  const double end_s = curve.knot_time_s.back();
  const double mirrored_s = time_s < 0.0 ? -time_s : 2.0 * end_s - time_s;
  const bool is_inside = time_s >= 0.0 && time_s <= end_s;
  Eigen::Vector3d at_m =
      curve_at(curve, is_inside ? time_s : std::clamp(mirrored_s, 0.0, end_s), cursor).position_m;
  if (is_inside) return at_m;
  const auto& knots_m = curve.knot_position_m;
  return 2.0 * (time_s < 0.0 ? knots_m.front() : knots_m.back()) - at_m;
}

}  // namespace

TrajectoryCurve band_limited(const TrajectoryCurve& curve, double tick_s) {
  if (curve.knot_time_s.size() < 3) return curve;
  const double end_s = curve.knot_time_s.back();
  const double knot_spacing_s = end_s / static_cast<double>(curve.knot_time_s.size() - 1);
  const double spacing_s = std::max(tick_s, knot_spacing_s);

  // Twice as many knots as needed: near the cut-off a spline through fewer has images of its own.
  // For the same reason the curve is sampled twice as often as it has knots.
  const auto intervals = static_cast<std::size_t>(std::ceil(end_s / (0.5 * spacing_s)));
  const double interval_s = end_s / static_cast<double>(intervals);
  const auto stride = static_cast<std::size_t>(std::ceil(interval_s / (0.5 * knot_spacing_s)));
  const double step_s = interval_s / static_cast<double>(stride);
  const std::vector<double> weights = low_pass_weights(0.5 * kCutoff / spacing_s, step_s);
  const std::size_t reach = weights.size() - 1;

  std::vector<Eigen::Vector3d> sampled_m(intervals * stride + 2 * reach + 1);
  CurveCursor cursor;
  for (std::size_t i = 0; i < sampled_m.size(); ++i) {
    const double steps = static_cast<double>(i) - static_cast<double>(reach);
    sampled_m[i] = continued_m(curve, steps * step_s, cursor);
  }
  std::vector<double> time_s;
  std::vector<Eigen::Vector3d> position_m;
  for (std::size_t knot = 0; knot <= intervals; ++knot) {
    const std::size_t middle = knot * stride + reach;
    Eigen::Vector3d sum_m = weights[0] * sampled_m[middle];
    for (std::size_t n = 1; n <= reach; ++n) {
      sum_m += weights[n] * (sampled_m[middle - n] + sampled_m[middle + n]);
    }
    time_s.push_back(end_s * static_cast<double>(knot) / static_cast<double>(intervals));
    position_m.push_back(sum_m);
  }
  TrajectoryCurve limited = spline_through(std::move(time_s), std::move(position_m));
  limited.row_time_s = curve.row_time_s;
  limited.orientation = curve.orientation;
  return limited;
}

}  // namespace stillgrid::devices
