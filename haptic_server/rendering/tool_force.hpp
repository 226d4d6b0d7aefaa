#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>

#include "haptic_server/rendering/touched_spheres.hpp"
#include "proto/scene_segment.hpp"

namespace stillgrid {

/// The tool in the scene, for one tick.
struct ToolPose {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  // of the tool's origin
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();
};

/// Force of the scene on the tool and its moment about the tool's origin, scene's axes, and the
/// number of contacts they are the sum of.
struct ToolForce {
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque_N_m = Eigen::Vector3d::Zero();
  int contacts = 0;
};

/// Sums the contact law over touched spheres and the scene's planes; the simulation uses the same
/// law.
///
/// Damper and friction see the velocity of the tool at the point of contact, its rotation included,
/// and the touched sphere's own. A contact divides the line of the centres as the radii do.
/// Realtime: allocates nothing. Spheres of unknown material are left out.
[[nodiscard]] ToolForce tool_force(const proto::SceneHeader& scene, const TouchedSpheres& touched,
                                   std::span<const PlacedToolSphere> tool,
                                   const ToolPose& pose) noexcept;

}  // namespace stillgrid
