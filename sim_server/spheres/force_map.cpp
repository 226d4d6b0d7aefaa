#include "sim_server/spheres/force_map.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "shared/collision/contact_law.hpp"

namespace stillgrid::spheres {

BallBody make_ball_body(std::span<const Ball> balls, double tool_radius_m) {
  return {{balls.begin(), balls.end()}, make_ball_grid(balls, tool_radius_m), tool_radius_m};
}

Eigen::Vector3d unit_force_m(const BallBody& body, const Eigen::Vector3d& tool_m) noexcept {
  constexpr collision::ContactMaterial kUnit{.stiffness_N_per_m = 1.0};
  Eigen::Vector3d force_m = Eigen::Vector3d::Zero();
  for (const std::uint32_t i : balls_near(body.grid, tool_m)) {
    const Eigen::Vector3d apart_m = tool_m - body.balls[i].centre_m;
    const double distance_m = apart_m.norm();
    const double depth_m = body.balls[i].radius_m + body.tool_radius_m - distance_m;
    // Centre on centre has no direction to push in.
    if (depth_m > 0.0 && distance_m > 0.0)
      force_m += collision::normal_force_N(kUnit, depth_m, 0.0) / distance_m * apart_m;
  }
  return force_m;
}

namespace {

/// The forces at all samples, this deep.
std::vector<Eigen::Vector3d> press(const SurfaceSamples& surface, double tool_radius_m,
                                   double depth_m, const UnitForce& force) {
  std::vector<Eigen::Vector3d> forces_m(surface.points_m.size());
  for (std::size_t i = 0; i < forces_m.size(); ++i)
    forces_m[i] = force(pressed_tool_m(surface, i, tool_radius_m, depth_m));
  return forces_m;
}

std::vector<double> along_normals(const std::vector<Eigen::Vector3d>& forces_m,
                                  const SurfaceSamples& surface) {
  std::vector<double> normal_m(forces_m.size());
  for (std::size_t i = 0; i < forces_m.size(); ++i)
    normal_m[i] = forces_m[i].dot(surface.normals[i]);
  return normal_m;
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double share_below(const std::vector<double>& values, double limit) {
  const auto below =
      std::count_if(values.begin(), values.end(), [limit](double value) { return value < limit; });
  return static_cast<double>(below) / static_cast<double>(values.size());
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

ForceMap map_force(const SurfaceSamples& surface, double tool_radius_m, double press_depth_m,
                   const UnitForce& force) {
  assert(!surface.points_m.empty() && press_depth_m > 0.0);
  const auto forces_m = press(surface, tool_radius_m, press_depth_m, force);
  const std::vector<double> normal_m = along_normals(forces_m, surface);
  const auto mean_at_m = [&](double depth_m) {
    return mean(along_normals(press(surface, tool_radius_m, depth_m, force), surface));
  };

  ForceMap map;
  const double step_m = 0.001 * press_depth_m;
  map.effective_stiffness =
      (mean_at_m(press_depth_m + step_m) - mean_at_m(press_depth_m - step_m)) / (2.0 * step_m);
  map.mean_m = mean(normal_m);
  // Without force at the median all samples are holes that have none.
  const double median_m = median(normal_m);
  map.hole_share = median_m > 0.0 ? share_below(normal_m, kHoleFraction * median_m)
                                  : share_below(normal_m, std::numeric_limits<double>::min());
  map.reversed_share = share_below(normal_m, 0.0);
  const auto [least, most] = std::minmax_element(normal_m.begin(), normal_m.end());
  if (!(map.mean_m > 0.0)) return map;
  map.min_over_max = *least / *most;
  map.peak_to_peak = (*most - *least) / map.mean_m;
  double squares_m2 = 0.0, sideways_m = 0.0;
  for (std::size_t i = 0; i < normal_m.size(); ++i) {
    squares_m2 += (normal_m[i] - map.mean_m) * (normal_m[i] - map.mean_m);
    sideways_m += (forces_m[i] - normal_m[i] * surface.normals[i]).norm();
  }
  const auto count = static_cast<double>(normal_m.size());
  map.ripple = std::sqrt(squares_m2 / count) / map.mean_m;
  map.tangential = sideways_m / count / map.mean_m;
  return map;
}

}  // namespace stillgrid::spheres
