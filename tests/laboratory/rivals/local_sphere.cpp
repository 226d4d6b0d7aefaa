#include "tests/laboratory/rivals/local_sphere.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid::laboratory {
namespace {

/// From which distance on a centre is as good as at infinity.
constexpr double kFlat_m = 1e3;

/// Distance of the centre of curvature below a place on the surface's level: how fast the normal
/// turns along two directions across it.
double centre_distance_m(const LocalScene& scene, std::uint32_t tool_sphere,
                         const rendering::PlacedToolSphere& probe,
                         const Eigen::Vector3d& normal) noexcept {
  const double step_m = 0.5 * probe.radius_m;
  const Eigen::Vector3d across = normal.unitOrthogonal();
  const Eigen::Vector3d ways[] = {across, -across, normal.cross(across), across.cross(normal)};
  double turned = 0.0;
  for (const Eigen::Vector3d& way : ways) {
    rendering::PlacedToolSphere aside = probe;
    aside.position_m += step_m * way;
    const auto surface = fit_surface(scene, tool_sphere, aside);
    if (surface) turned += 0.25 * surface->normal.dot(way);
  }
  // Seen from one centre, a normal at a step aside turns by step / sqrt(distance^2 + step^2).
  if (!(turned * kFlat_m > step_m)) return kFlat_m;
  return std::max(1e-3 * step_m, step_m * std::sqrt(std::max(0.0, 1.0 / (turned * turned) - 1.0)));
}

}  // namespace

void LocalSphere::update(const LocalScene& scene, const PlacedTool& sampled, const PlacedTool&,
                         bool) noexcept {
  for (std::uint32_t i = 0; i < sampled.spheres.size(); ++i) {
    spheres_[i].reset();
    const rendering::PlacedToolSphere& probe = sampled.spheres[i];
    const auto surface = fit_surface(scene, i, probe);
    if (!surface) continue;
    const double distance_m = centre_distance_m(scene, i, probe, surface->normal);
    spheres_[i] = {*surface, probe.position_m - distance_m * surface->normal,
                   distance_m + surface->depth_m};
  }
}

rendering::ToolForce LocalSphere::force(const LocalScene&, const PlacedTool& tool) noexcept {
  rendering::ToolForce sum;
  for (std::size_t i = 0; i < tool.spheres.size(); ++i) {
    if (!spheres_[i]) continue;
    const auto& [surface, centre_m, contact_distance_m] = *spheres_[i];
    const Eigen::Vector3d line_m = tool.spheres[i].position_m - centre_m;
    const double distance_m = line_m.norm();
    const Eigen::Vector3d normal =
        distance_m > 1e-12 ? Eigen::Vector3d(line_m / distance_m) : surface.normal;
    add_surface(sum, surface, contact_distance_m - distance_m, normal, tool.spheres[i], tool.pose);
  }
  return sum;
}

}  // namespace stillgrid::laboratory
