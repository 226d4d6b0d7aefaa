#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>

#include "proto/scene_segment.hpp"
#include "shared/collision/contact_law.hpp"
#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::rendering {

/// The tool in the scene, for one tick.
struct ToolPose {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  // of the tool's origin
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();
};

/// Force of the scene on the tool and its moment about the tool's origin, scene's axes; the number
/// of contacts they are the sum of, and the stiffness of their springs: the sum of k n n^T.
struct ToolForce {
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque_N_m = Eigen::Vector3d::Zero();
  int contacts = 0;
  Eigen::Matrix3d stiffness_N_per_m = Eigen::Matrix3d::Zero();
  double static_J = 0.0;     // that its springs hold against what never moves
  bool is_crushing = false;  // see kFlagCrushed
};

/// A contact of a sphere of the tool, or the distance to what it does not touch.
struct ToolContact {
  double depth_m;          // of the overlap; negative: the distance between
  Eigen::Vector3d normal;  // towards the tool
  Eigen::Vector3d point_m;
  Eigen::Vector3d touched_velocity_m_s;
};

/// A contact divides the line of the centres as the radii do. Realtime: yes.
[[nodiscard]] ToolContact contact_with(const TouchedSphere& sphere,
                                       const PlacedToolSphere& probe) noexcept;
[[nodiscard]] ToolContact contact_with(const proto::Plane& plane,
                                       const PlacedToolSphere& probe) noexcept;

/// The constants of the tool's contact with that material. Realtime: yes.
/// Pre: material < scene.material_count.
[[nodiscard]] collision::ContactMaterial contact_material(const proto::SceneHeader& scene,
                                                          std::uint32_t material) noexcept;

/// Returns the velocity of the tool at the point of contact relative to the touched surface, m/s.
/// Realtime: yes.
[[nodiscard]] inline Eigen::Vector3d relative_velocity_m_s(const ToolContact& contact,
                                                           const ToolPose& pose) noexcept {
  const Eigen::Vector3d lever_m = contact.point_m - pose.position_m;
  return pose.velocity_m_s + pose.angular_velocity_rad_s.cross(lever_m) -
         contact.touched_velocity_m_s;
}

/// Adds the share `presence` of a contact's force by the contact law; without overlap nothing.
///
/// Damper and friction see the velocity of the tool at the point of contact, its rotation included,
/// and the touched body's own. Realtime: yes.
void add_contact(ToolForce& sum, const collision::ContactMaterial& material,
                 const ToolContact& contact, const ToolPose& pose, double presence = 1.0) noexcept;

/// Returns the force of one sphere.
[[nodiscard]] ToolForce sphere_force_of(const proto::SceneHeader& scene,
                                        const TouchedSphere& sphere,
                                        std::span<const PlacedToolSphere> tool,
                                        const ToolPose& pose) noexcept;

/// Sums the contact law over touched spheres; the simulation uses the same law.
///
/// Realtime: allocates nothing. Spheres of unknown material are left out.
[[nodiscard]] ToolForce sphere_force(const proto::SceneHeader& scene, const TouchedSpheres& touched,
                                     std::span<const PlacedToolSphere> tool,
                                     const ToolPose& pose) noexcept;

/// The same over touched spheres and the scene's planes. Realtime: as sphere_force().
[[nodiscard]] ToolForce tool_force(const proto::SceneHeader& scene, const TouchedSpheres& touched,
                                   std::span<const PlacedToolSphere> tool,
                                   const ToolPose& pose) noexcept;

}  // namespace stillgrid::rendering
