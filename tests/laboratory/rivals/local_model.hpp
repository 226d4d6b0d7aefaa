#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "proto/scene_segment.hpp"
#include "shared/rendering/placed_tool.hpp"
#include "shared/rendering/tool_force.hpp"
#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::laboratory {

/// What the slow process would hand over: the spheres near the tool in one snapshot, and what never
/// changes. A sphere of the patch is there for one sphere of the tool, overlapping it or not.
struct LocalScene {
  const proto::SceneHeader& fixed;
  const rendering::TouchedSpheres& patch;
  std::uint64_t state_time_ns = 0;  // of the snapshot; to update() alone, as is
  std::size_t moving = 0;           // how many of the patch are of bodies that move: the first
};

/// The tool at one instant.
struct PlacedTool {
  const rendering::ToolPose& pose;
  std::span<const rendering::PlacedToolSphere> spheres;  // placed at `pose`
  std::uint64_t time_ns = 0;                             // of the tick; nothing needs a sample's
};

/// An intermediate model of the scene near the tool: made anew from each snapshot, asked at each
/// tick.
///
/// All functions: Realtime: bounded work, allocates nothing.
class LocalModel {
 public:
  LocalModel() = default;
  virtual ~LocalModel() = default;
  LocalModel(const LocalModel&) = delete;
  LocalModel& operator=(const LocalModel&) = delete;
  LocalModel(LocalModel&&) = delete;
  LocalModel& operator=(LocalModel&&) = delete;

  /// Widens the balls that a patch is gathered in, one a tool sphere, by what the model stands on.
  virtual void widen(std::span<rendering::PlacedToolSphere>) const noexcept {}

  /// Makes the model of a new snapshot. sampled: the tool that the snapshot was computed with;
  /// present: the tool of this tick. is_first: whatever was there before is of no account.
  virtual void update(const LocalScene& scene, const PlacedTool& sampled, const PlacedTool& present,
                      bool is_first) noexcept = 0;

  /// The force on the tool. scene: that of the last update.
  [[nodiscard]] virtual rendering::ToolForce force(const LocalScene& scene,
                                                   const PlacedTool& tool) noexcept = 0;
};

}  // namespace stillgrid::laboratory
