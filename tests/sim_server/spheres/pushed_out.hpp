#pragma once

#include <algorithm>
#include <limits>
#include <span>

#include "sim_server/spheres/decomposition_candidates.hpp"
#include "sim_server/spheres/decomposition_error.hpp"
#include "sim_server/spheres/force_map.hpp"

namespace stillgrid::spheres {

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
  const BallBody body = make_ball_body(balls, tool_radius_m);
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
      const double push = unit_force_m(body, tool_m).dot(normal) / depth_m;
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
