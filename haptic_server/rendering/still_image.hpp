#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "haptic_server/rendering/tool_force.hpp"
#include "haptic_server/rendering/touched_spheres.hpp"
#include "haptic_server/rendering/transition.hpp"
#include "shared/publication/scene_segment.hpp"

namespace stillgrid {

/// What one tick rendered.
struct RenderedTick {
  ToolForce force;
  std::uint64_t generation = 0;  // of the image shown, 0: none yet
  bool is_new = false;           // the first tick that shows it
  double alpha = 1.0;
  double age_s = 0.0;                   // of the simulated state shown newest
  double image_age_s = 0.0;             // since its publication
  bool contended = false;               // no fresh read: the last good sample was used
  bool cut = false;                     // the tick's bound on work was met
  bool swept = false;                   // a contact that was only on the way to this tick
  std::optional<double> switch_jump_N;  // at a switch: |force by new image - force by old one|
};

/// Renders the scene's force from its still images: the paper's intermediate model.
///
/// Thread: the haptic loop's only.
class StillImageRenderer {
 public:
  explicit StillImageRenderer(Transition transition) : transition_(transition) {}
  ~StillImageRenderer() = default;
  StillImageRenderer(const StillImageRenderer&) = delete;
  StillImageRenderer& operator=(const StillImageRenderer&) = delete;
  StillImageRenderer(StillImageRenderer&&) = delete;
  StillImageRenderer& operator=(StillImageRenderer&&) = delete;

  /// Reads the latest image in place, gathers what the tool touches where the transition shows it,
  /// and only after the read was accepted sums the force.
  ///
  /// now_ns: on the clock of the scene's stamps. Realtime: wait-free, allocates nothing.
  [[nodiscard]] RenderedTick render(const SceneView& scene, const ToolPose& pose,
                                    std::uint64_t now_ns) noexcept;

 private:
  std::span<PlacedToolSphere> place(const proto::SceneHeader& scene, const ToolPose& tool);

  Transition transition_;
  std::uint64_t epoch_ = 0;           // of the segment that what follows came from
  proto::SnapshotHeader snapshot_{};  // of the last accepted read
  ImageWeights weights_;              // likewise, as it was displayed
  TouchedSpheres buffers_[2], before_switch_;
  TouchedSpheres* touched_ = &buffers_[0];  // of the last accepted read
  TouchedSpheres* fresh_ = &buffers_[1];    // being gathered
  std::array<PlacedToolSphere, proto::kMaxToolSpheres> tool_;
  bool has_way_ = false;  // whether an accepted read of this scene placed the tool before
};

}  // namespace stillgrid
