#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "haptic_server/rendering/renderer.hpp"
#include "haptic_server/rendering/touched_spheres.hpp"
#include "proto/scene_segment.hpp"

namespace stillgrid {

using ToolSpheres = std::array<PlacedToolSphere, proto::kMaxToolSpheres>;

/// Places the scene's tool at a pose, with no way behind it: nothing is swept.
/// Realtime: allocates nothing. Pre: scene.tool_sphere_count <= kMaxToolSpheres.
std::span<PlacedToolSphere> place_tool(const proto::SceneHeader& scene, const ToolPose& pose,
                                       ToolSpheres& placed) noexcept;

/// What a tick at now_ns says of the image that it shows, all but its force.
[[nodiscard]] RenderedTick tick_showing(const proto::SnapshotHeader& snapshot,
                                        std::uint64_t now_ns) noexcept;

/// The image numbered `image` in the history (0: the newest), held.
[[nodiscard]] DisplayedMotion held_image(std::size_t image) noexcept;

}  // namespace stillgrid
