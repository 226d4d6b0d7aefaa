#pragma once

#include <cstdint>

#include "haptic_server/rendering/renderer.hpp"
#include "haptic_server/rendering/tool_way.hpp"
#include "haptic_server/rendering/touched_spheres.hpp"
#include "haptic_server/rendering/transition.hpp"
#include "shared/publication/scene_segment.hpp"

namespace stillgrid {

/// Renders the scene's force from its still images: the paper's intermediate model, with every
/// transition that displays sums of them.
///
/// Thread: the haptic loop's only.
class StillImageRenderer final : public Renderer {
 public:
  /// Pre: transition is not kAnswer.
  explicit StillImageRenderer(Transition transition) : transition_(transition) {}

  /// Reads the latest image in place, gathers what the tool touches where the transition shows it,
  /// and only after the read was accepted sums the force.
  [[nodiscard]] RenderedTick render(const SceneView& scene, const ToolPose& pose,
                                    std::uint64_t now_ns) noexcept override;

 private:
  Transition transition_;
  std::uint64_t epoch_ = 0;           // of the segment that what follows came from
  proto::SnapshotHeader snapshot_{};  // of the last accepted read
  TransitionMemory memory_;           // with which it is displayed
  ImageWeights weights_;              // likewise, as it was displayed
  TouchedSpheres buffers_[2], before_switch_;
  TouchedSpheres* touched_ = &buffers_[0];  // of the last accepted read
  TouchedSpheres* fresh_ = &buffers_[1];    // being gathered
  ToolWay tool_;
};

}  // namespace stillgrid
