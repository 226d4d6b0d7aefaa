#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "sim_server/spheres/ball_grid.hpp"
#include "sim_server/spheres/decomposition_candidates.hpp"
#include "sim_server/spheres/decomposition_error.hpp"

namespace stillgrid::spheres {

/// Returns the sum of springs of 1 N/m between a tool sphere and balls, N for each N/m.
/// Pre: grid is of the balls, with the tool's radius as its search radius.
inline Eigen::Vector3d sum_of_springs_m(std::span<const Ball> balls, const BallGrid& grid,
                                        const Eigen::Vector3d& tool_m, double tool_radius_m) {
  Eigen::Vector3d force_m = Eigen::Vector3d::Zero();
  for (const std::uint32_t i : balls_near(grid, tool_m)) {
    const Eigen::Vector3d apart_m = tool_m - balls[i].centre_m;
    const double depth_m = balls[i].radius_m + tool_radius_m - apart_m.norm();
    if (depth_m > 0.0) force_m += depth_m * apart_m.normalized();
  }
  return force_m;
}

/// How well balls push a tool out that is pressed into a solid.
struct PushedOut {
  double least = std::numeric_limits<double>::infinity();  // force along the normal over the depth
  std::size_t paths = 0, presses = 0;
  Eigen::Vector3d worst_m = Eigen::Vector3d::Zero();
};

/// Presses a tool sphere along the inward normal of places all over the surface, from first_m deep
/// until its centre has gone that share of the way to the medial axis, flat edges of facets apart.
/// Places: where a ball of fineness_m fits under the surface and nothing else of it is in the
/// tool's way.
inline PushedOut press_in(const MeshSolid& solid, std::span<const Ball> balls, double tool_radius_m,
                          double first_m, double share, double fineness_m, std::size_t places) {
  constexpr int kSteps = 24;
  const SurfaceSamples surface = sample_surface(solid.mesh, places);
  const BallGrid grid = make_ball_grid(balls, tool_radius_m);
  PushedOut found;
  for (std::size_t i = 0; i < surface.points_m.size(); ++i) {
    const Eigen::Vector3d &point_m = surface.points_m[i], &normal = surface.normals[i];
    const double axis_m = medial_ball(solid, point_m, normal, 0.1 * fineness_m).radius_m;
    if (axis_m < fineness_m) continue;
    const double last_m = tool_radius_m + share * axis_m;
    for (int step = 0; step <= kSteps && first_m < last_m; ++step) {
      const double depth_m = first_m + (last_m - first_m) * step / kSteps;
      const Eigen::Vector3d tool_m = point_m + (tool_radius_m - depth_m) * normal;
      if (tool_radius_m - solid.distance.signed_distance_m(tool_m) > 1.1 * depth_m) break;
      const double push =
          sum_of_springs_m(balls, grid, tool_m, tool_radius_m).dot(normal) / depth_m;
      if (push < found.least) {
        found.least = push;
        found.worst_m = point_m;
      }
      ++found.presses;
      if (step == 0) ++found.paths;
    }
  }
  return found;
}

}  // namespace stillgrid::spheres
