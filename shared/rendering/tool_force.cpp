#include "shared/rendering/tool_force.hpp"

#include <algorithm>

namespace stillgrid::rendering {

ToolContact contact_with(const TouchedSphere& sphere, const PlacedToolSphere& probe) noexcept {
  const Eigen::Vector3d way_m = probe.position_m - sphere.position_m;
  const double distance_m = way_m.norm(), contact_distance_m = probe.radius_m + sphere.radius_m;
  const Eigen::Vector3d normal =
      distance_m > 1e-12 ? Eigen::Vector3d(way_m / distance_m) : Eigen::Vector3d::UnitZ();
  return {contact_distance_m - distance_m, normal,
          probe.position_m - probe.radius_m / contact_distance_m * distance_m * normal,
          sphere.velocity_m_s};
}

ToolContact contact_with(const proto::Plane& plane, const PlacedToolSphere& probe) noexcept {
  const Eigen::Vector3d normal(plane.normal[0], plane.normal[1], plane.normal[2]);
  return {probe.radius_m - (normal.dot(probe.position_m) - plane.offset_m), normal,
          probe.position_m - probe.radius_m * normal, Eigen::Vector3d::Zero()};
}

collision::ContactMaterial contact_material(const proto::SceneHeader& scene,
                                            std::uint32_t material) noexcept {
  const proto::Material& m = scene.materials[material];
  return collision::tool_material(
      {m.stiffness_N_per_m, m.damping_N_s_per_m, m.friction, m.slip_speed_m_s},
      scene.tool_slip_speed_m_s);
}

void add_contact(ToolForce& sum, const collision::ContactMaterial& material,
                 const ToolContact& contact, const ToolPose& pose, double presence) noexcept {
  if (!(contact.depth_m > 0.0)) return;
  const Eigen::Vector3d lever_m = contact.point_m - pose.position_m;
  const Eigen::Vector3d force_N =
      presence * collision::contact_force_N(material, contact.depth_m, contact.normal,
                                            relative_velocity_m_s(contact, pose));
  sum.force_N += force_N;
  sum.torque_N_m += lever_m.cross(force_N);
  sum.stiffness_N_per_m +=
      presence * material.stiffness_N_per_m * contact.normal * contact.normal.transpose();
  ++sum.contacts;
}

namespace {

/// Of the spring.
double energy_J(const collision::ContactMaterial& material, const ToolContact& contact) {
  const double depth_m = std::max(0.0, contact.depth_m);
  return 0.5 * material.stiffness_N_per_m * depth_m * depth_m;
}

void add_sphere(ToolForce& sum, const proto::SceneHeader& scene, const TouchedSphere& sphere,
                std::span<const PlacedToolSphere> tool, const ToolPose& pose) noexcept {
  // A tick may show the spheres of the tick before, gathered for a tool of another scene.
  if (sphere.material >= scene.material_count || sphere.tool_sphere >= tool.size()) return;
  const collision::ContactMaterial material = contact_material(scene, sphere.material);
  const ToolContact contact = contact_with(sphere, tool[sphere.tool_sphere]);
  add_contact(sum, material, contact, pose, sphere.presence);
  if (sphere.is_static)
    sum.static_J += sphere.energy_share * sphere.presence * energy_J(material, contact);
}

}  // namespace

ToolForce sphere_force_of(const proto::SceneHeader& scene, const TouchedSphere& sphere,
                          std::span<const PlacedToolSphere> tool, const ToolPose& pose) noexcept {
  ToolForce one;
  add_sphere(one, scene, sphere, tool, pose);
  return one;
}

ToolForce sphere_force(const proto::SceneHeader& scene, const TouchedSpheres& touched,
                       std::span<const PlacedToolSphere> tool, const ToolPose& pose) noexcept {
  ToolForce sum;
  for (const TouchedSphere& sphere : touched.all()) add_sphere(sum, scene, sphere, tool, pose);
  return sum;
}

ToolForce tool_force(const proto::SceneHeader& scene, const TouchedSpheres& touched,
                     std::span<const PlacedToolSphere> tool, const ToolPose& pose) noexcept {
  ToolForce sum = sphere_force(scene, touched, tool, pose);
  for (std::uint32_t i = 0; i < scene.plane_count; ++i) {
    const proto::Plane& plane = scene.planes[i];
    const collision::ContactMaterial material = contact_material(scene, plane.material);
    for (const PlacedToolSphere& probe : tool) {
      const ToolContact contact = contact_with(plane, probe);
      add_contact(sum, material, contact, pose);
      sum.static_J += energy_J(material, contact);
    }
  }
  return sum;
}

}  // namespace stillgrid::rendering
