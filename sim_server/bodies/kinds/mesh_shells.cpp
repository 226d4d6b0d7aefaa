#include "sim_server/bodies/kinds/mesh_shells.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "sim_server/bodies/kinds/body_description.hpp"
#include "sim_server/mesh/mass_properties.hpp"
#include "sim_server/spheres/sampling.hpp"

namespace stillgrid::bodies {
namespace {

constexpr double kOfTool = 0.25, kOfMesh = 1.0 / 64.0;
constexpr double kMaxStill = 5e4, kMaxMoving = 5e3;  // every sphere that moves is placed a step
/// Of area over radius squared: points that are strewn a spacing apart are not dense.
constexpr double kDensity = 0.8 / (spheres::kShellSpacing * spheres::kShellSpacing);

double radius_m(const mesh::TriangleMesh& surface, double tool_radius_m, double most) {
  const double fine_m =
      std::min(kOfTool * tool_radius_m, kOfMesh * box_of(surface).sizes().maxCoeff());
  return std::max(fine_m, std::sqrt(kDensity * mesh::surface_area_m2(surface) / most));
}

}  // namespace

void cover_shells(std::span<BodyDescription> bodies, const FieldScene& scene,
                  std::vector<std::string>& notes) {
  for (BodyDescription& body : bodies) {
    auto* const shell = std::get_if<RigidMeshBody>(&body.shape);
    if (shell == nullptr || shell->no_solid.empty()) continue;
    const double sphere_m = radius_m(shell->surface, scene.least_tool_radius_m,
                                     body.motion == Motion::kStatic ? kMaxStill : kMaxMoving);
    shell->balls = spheres::shell_balls(shell->surface, sphere_m);
    std::array<char, 100> text{};
    std::snprintf(text.data(), text.size(),
                  ": a thin shell of %zu spheres of %.3g m, felt from both sides",
                  shell->balls.size(), sphere_m);
    notes.push_back("body '" + body.name + "': " + shell->no_solid + text.data());
  }
}

}  // namespace stillgrid::bodies
