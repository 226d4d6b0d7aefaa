#pragma once

#include <Eigen/Core>
#include <span>

#include "haptic_server/rendering/touched_spheres.hpp"
#include "proto/scene_segment.hpp"

namespace stillgrid {

/// Force of the scene on the tool, and the number of contacts it is the sum of.
struct ToolForce {
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
  int contacts = 0;
};

/// Sums the contact law over touched spheres and the scene's planes; the simulation uses the same
/// law.
///
/// velocity_m_s: of the tool; a touched sphere keeps its own, for damper and friction.
/// Realtime: allocates nothing. Spheres of unknown material are left out.
[[nodiscard]] ToolForce tool_force(const proto::SceneHeader& scene, const TouchedSpheres& touched,
                                   std::span<const PlacedToolSphere> tool,
                                   const Eigen::Vector3d& velocity_m_s) noexcept;

}  // namespace stillgrid
