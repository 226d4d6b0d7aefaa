#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "proto/scene_segment.hpp"
#include "shared/rendering/tool_force.hpp"
#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::rendering {

using ToolSpheres = std::array<PlacedToolSphere, proto::kMaxToolSpheres>;

/// Places the scene's tool at a pose, with no way behind it: nothing is swept.
/// Realtime: allocates nothing. Pre: scene.tool_sphere_count <= kMaxToolSpheres.
std::span<PlacedToolSphere> place_tool(const proto::SceneHeader& scene, const ToolPose& pose,
                                       ToolSpheres& placed) noexcept;

/// The tool's spheres with the way that they went since the last tick that saw the scene.
class ToolSweep {
 public:
  /// Places the tool. Realtime: allocates nothing. Pre: as of place_tool().
  std::span<PlacedToolSphere> place(const proto::SceneHeader& scene,
                                    const ToolPose& pose) noexcept {
    const ToolSpheres before = spheres_;
    const std::span<PlacedToolSphere> tool = place_tool(scene, pose, spheres_);
    if (has_sweep_)
      for (std::size_t i = 0; i < tool.size(); ++i) tool[i].before_m = before[i].before_m;
    return tool;
  }

  /// The scene was seen: the next way begins here.
  void end() noexcept {
    for (PlacedToolSphere& sphere : spheres_) sphere.before_m = sphere.position_m;
    has_sweep_ = true;
  }

  /// There was no scene, or it was another.
  void forget() noexcept { has_sweep_ = false; }

 private:
  ToolSpheres spheres_{};
  bool has_sweep_ = false;
};

}  // namespace stillgrid::rendering
