#include "tests/laboratory/rivals/local_surface.hpp"

namespace stillgrid::laboratory {
namespace {

template <class Visit>
void for_each_contact(const LocalScene& scene, std::uint32_t tool_sphere,
                      const rendering::PlacedToolSphere& probe, Visit&& visit) {
  for (const rendering::TouchedSphere& sphere : scene.patch.all())
    if (sphere.tool_sphere == tool_sphere && sphere.material < scene.fixed.material_count)
      visit(rendering::contact_material(scene.fixed, sphere.material),
            rendering::contact_with(sphere, probe));
  for (std::uint32_t i = 0; i < scene.fixed.plane_count; ++i) {
    const proto::Plane& plane = scene.fixed.planes[i];
    visit(rendering::contact_material(scene.fixed, plane.material),
          rendering::contact_with(plane, probe));
  }
}

}  // namespace

std::optional<LocalSurface> fit_surface(const LocalScene& scene, std::uint32_t tool_sphere,
                                        const rendering::PlacedToolSphere& probe) noexcept {
  std::optional<LocalSurface> nearest;
  Eigen::Vector3d sum_N = Eigen::Vector3d::Zero(), momentum = Eigen::Vector3d::Zero();
  double normal_load_N = 0.0;
  for_each_contact(
      scene, tool_sphere, probe,
      [&](const collision::ContactMaterial& material, const rendering::ToolContact& contact) {
        if (!nearest || contact.depth_m > nearest->depth_m)
          nearest = {contact.normal, contact.depth_m, material, contact.touched_velocity_m_s};
        if (!(contact.depth_m > 0.0)) return;
        const double spring_N = material.stiffness_N_per_m * contact.depth_m;
        sum_N += spring_N * contact.normal;
        normal_load_N += spring_N;
        momentum += spring_N * contact.touched_velocity_m_s;
      });
  // Contacts that cancel have no common normal; the deepest one's is as good as any.
  constexpr double kCancelled = 1e-6;
  if (!(sum_N.norm() > kCancelled * normal_load_N)) return nearest;

  LocalSurface surface = *nearest;  // friction is the deepest's
  surface.normal = sum_N.normalized();
  surface.velocity_m_s = momentum / normal_load_N;
  surface.material.stiffness_N_per_m = surface.material.damping_N_s_per_m = 0.0;
  for_each_contact(
      scene, tool_sphere, probe,
      [&](const collision::ContactMaterial& material, const rendering::ToolContact& contact) {
        if (!(contact.depth_m > 0.0)) return;
        const double share = contact.normal.dot(surface.normal);
        surface.material.stiffness_N_per_m += share * share * material.stiffness_N_per_m;
        surface.material.damping_N_s_per_m += share * share * material.damping_N_s_per_m;
      });
  surface.depth_m = sum_N.norm() / surface.material.stiffness_N_per_m;
  return surface;
}

void add_surface(rendering::ToolForce& sum, const LocalSurface& surface, double depth_m,
                 const Eigen::Vector3d& normal, const rendering::PlacedToolSphere& probe,
                 const rendering::ToolPose& pose) noexcept {
  rendering::add_contact(
      sum, surface.material,
      {depth_m, normal, probe.position_m - probe.radius_m * normal, surface.velocity_m_s}, pose);
}

}  // namespace stillgrid::laboratory
