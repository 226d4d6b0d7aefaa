#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "haptic_server/rendering/tool_force.hpp"
#include "haptic_server/rendering/touched_spheres.hpp"
#include "proto/scene_segment.hpp"

namespace stillgrid {

using ToolSpheres = std::array<PlacedToolSphere, proto::kMaxToolSpheres>;

/// Places the scene's tool at a pose, with no way behind it: nothing is swept.
/// Realtime: allocates nothing. Pre: scene.tool_sphere_count <= kMaxToolSpheres.
std::span<PlacedToolSphere> place_tool(const proto::SceneHeader& scene, const ToolPose& pose,
                                       ToolSpheres& placed) noexcept;

/// The image numbered `image` in the history (0: the newest), held.
[[nodiscard]] DisplayedMotion held_image(std::size_t image) noexcept;

}  // namespace stillgrid
