#include "sim_server/spheres/effective_stiffness.hpp"

#include <stdexcept>
#include <string>

#include "sim_server/spheres/force_map.hpp"

namespace stillgrid::spheres {

double effective_stiffness(std::span<const Ball> balls, const SurfaceSamples& surface,
                           double tool_radius_m, double press_depth_m) {
  const BallBody body = make_ball_body(balls, tool_radius_m);
  return map_force(surface, tool_radius_m, press_depth_m,
                   [&](const Eigen::Vector3d& tool_m) { return unit_force_m(body, tool_m); })
      .effective_stiffness;
}

double stiffness_scale(std::span<const Ball> balls, const SurfaceSamples& surface,
                       double tool_radius_m, double press_depth_m) {
  const double stiffness = effective_stiffness(balls, surface, tool_radius_m, press_depth_m);
  if (!(stiffness > 0.0))
    throw std::runtime_error("press_depth_m = " + std::to_string(press_depth_m) +
                             ": expected a depth at which the " + std::to_string(balls.size()) +
                             " balls push a tool of radius " + std::to_string(tool_radius_m) +
                             " m back");
  return 1.0 / stiffness;
}

}  // namespace stillgrid::spheres
