#include "sim_server/spheres/feel.hpp"

#include <array>
#include <cstdio>

namespace stillgrid::spheres {

Feel feel_of(std::span<const Ball> balls, const mesh::MeshDistance& mesh, const Press& press) {
  const BallBody body = make_ball_body(balls, press.tool_radius_m);
  const UnitForce force = [&](const Eigen::Vector3d& tool_m) { return unit_force_m(body, tool_m); };
  return {felt_error(exact_forces(press.surface, mesh, press.tool_radius_m, press.depth_m), force),
          map_force(press.surface, press.tool_radius_m, press.depth_m, force)};
}

bool is_worse_than_nearest_face(const Feel& feel) {
  return !(feel.error.jnd() < 1.0) || feel.map.hole_share > 0.0 || feel.map.reversed_share > 0.0;
}

std::string fault_of(const Feel& feel) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "%.2g JND from the mesh", feel.error.jnd());
  std::string fault = text.data();
  if (feel.map.hole_share > 0.0) {
    std::snprintf(text.data(), text.size(), ", with holes at %.2g %% of places",
                  100.0 * feel.map.hole_share);
    fault += text.data();
  }
  if (feel.map.reversed_share > 0.0) {
    std::snprintf(text.data(), text.size(), ", pulled in at %.2g %%",
                  100.0 * feel.map.reversed_share);
    fault += text.data();
  }
  return fault;
}

}  // namespace stillgrid::spheres
