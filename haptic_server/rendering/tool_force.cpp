#include "haptic_server/rendering/tool_force.hpp"

#include "shared/collision/contact_law.hpp"

namespace stillgrid {
namespace {

/// Pre: index < scene.material_count.
ContactMaterial material_of(const proto::SceneHeader& scene, std::uint32_t index) {
  const proto::Material& m = scene.materials[index];
  return tool_material({m.stiffness_N_m, m.damping_N_s_m, m.friction, m.slip_speed_m_s},
                       scene.tool_slip_speed_m_s);
}

/// One contact of the tool, all lengths in metres.
struct ToolContact {
  double depth_m;
  Eigen::Vector3d normal;   // towards the tool
  Eigen::Vector3d point_m;  // from the tool's origin
  Eigen::Vector3d touched_velocity_m_s;
};

void add(ToolForce& sum, const ContactMaterial& material, const ToolContact& contact,
         const ToolPose& pose) {
  if (!(contact.depth_m > 0.0)) return;
  const Eigen::Vector3d velocity_m_s =
      pose.velocity_m_s + pose.angular_velocity_rad_s.cross(contact.point_m);
  const Eigen::Vector3d force_N = contact_force_N(material, contact.depth_m, contact.normal,
                                                  velocity_m_s - contact.touched_velocity_m_s);
  sum.force_N += force_N;
  sum.torque_N_m += contact.point_m.cross(force_N);
  ++sum.contacts;
}

}  // namespace

ToolForce tool_force(const proto::SceneHeader& scene, const TouchedSpheres& touched,
                     std::span<const PlacedToolSphere> tool, const ToolPose& pose) noexcept {
  ToolForce sum;
  for (const TouchedSphere& sphere : touched.all()) {
    // A tick may show the spheres of the tick before, gathered for a tool of another scene.
    if (sphere.material >= scene.material_count || sphere.tool_sphere >= tool.size()) continue;
    const PlacedToolSphere& probe = tool[sphere.tool_sphere];
    const Eigen::Vector3d line_m = probe.position_m - sphere.position_m;
    const double distance_m = line_m.norm(), reach_m = probe.radius_m + sphere.radius_m;
    const Eigen::Vector3d normal =
        distance_m > 1e-12 ? Eigen::Vector3d(line_m / distance_m) : Eigen::Vector3d::UnitZ();
    add(sum, material_of(scene, sphere.material),
        {reach_m - distance_m, normal,
         probe.position_m - probe.radius_m / reach_m * line_m - pose.position_m,
         sphere.velocity_m_s},
        pose);
  }
  for (std::uint32_t i = 0; i < scene.plane_count; ++i) {
    const proto::Plane& plane = scene.planes[i];
    const Eigen::Vector3d normal(plane.normal[0], plane.normal[1], plane.normal[2]);
    const ContactMaterial material = material_of(scene, plane.material);
    for (const PlacedToolSphere& probe : tool)
      add(sum, material,
          {probe.radius_m - (normal.dot(probe.position_m) - plane.offset_m), normal,
           probe.position_m - probe.radius_m * normal - pose.position_m, Eigen::Vector3d::Zero()},
          pose);
  }
  return sum;
}

}  // namespace stillgrid
