#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "proto/scene_segment.hpp"
#include "shared/rendering/tool_force.hpp"
#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::rendering {

using ToolSpheres = std::array<PlacedToolSphere, proto::kMaxToolSpheres>;

/// Places the scene's tool at a pose.
/// Realtime: allocates nothing. Pre: scene.tool_sphere_count <= kMaxToolSpheres.
std::span<PlacedToolSphere> place_tool(const proto::SceneHeader& scene, const ToolPose& pose,
                                       ToolSpheres& placed) noexcept;

}  // namespace stillgrid::rendering
