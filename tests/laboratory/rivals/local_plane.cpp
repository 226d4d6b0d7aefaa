#include "tests/laboratory/rivals/local_plane.hpp"

#include <algorithm>

#include "shared/display/stamps.hpp"

namespace stillgrid::laboratory {

double LocalPlane::depth_m(const Plane& plane, const rendering::PlacedToolSphere& probe,
                           std::uint64_t now_ns) const noexcept {
  const double since_s = display::seconds_between(updated_ns_, now_ns);
  const double left = since_s < recovery_s_ ? 1.0 - since_s / recovery_s_ : 0.0;
  return plane.surface.depth_m - plane.surface.normal.dot(probe.position_m - plane.fitted_at_m) -
         left * plane.set_back_m;
}

void LocalPlane::update(const LocalScene& scene, const PlacedTool& sampled,
                        const PlacedTool& present, bool is_first) noexcept {
  std::array<double, proto::kMaxToolSpheres> pressed_N{};
  for (std::size_t i = 0; i < present.spheres.size() && !is_first; ++i)
    if (planes_[i])
      pressed_N[i] = planes_[i]->surface.material.stiffness_N_per_m *
                     std::max(0.0, depth_m(*planes_[i], present.spheres[i], present.time_ns));
  updated_ns_ = present.time_ns;
  for (std::uint32_t i = 0; i < present.spheres.size(); ++i) {
    planes_[i].reset();
    const auto surface = fit_surface(scene, i, sampled.spheres[i]);
    if (!surface) continue;
    Plane plane{*surface, sampled.spheres[i].position_m};
    const double deep_m = depth_m(plane, present.spheres[i], present.time_ns);
    const double stiffness_N_per_m = surface->material.stiffness_N_per_m;
    if (deep_m > 0.0 && stiffness_N_per_m > 0.0)
      plane.set_back_m = deep_m - pressed_N[i] / stiffness_N_per_m;
    planes_[i] = plane;
  }
}

rendering::ToolForce LocalPlane::force(const LocalScene&, const PlacedTool& tool) noexcept {
  rendering::ToolForce sum;
  for (std::size_t i = 0; i < tool.spheres.size(); ++i)
    if (planes_[i])
      add_surface(sum, planes_[i]->surface, depth_m(*planes_[i], tool.spheres[i], tool.time_ns),
                  planes_[i]->surface.normal, tool.spheres[i], tool.pose);
  return sum;
}

}  // namespace stillgrid::laboratory
