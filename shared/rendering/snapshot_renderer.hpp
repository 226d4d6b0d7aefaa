#pragma once

#include <span>

#include "shared/rendering/placed_tool.hpp"
#include "shared/rendering/renderer.hpp"
#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::rendering {

/// Renders the scene's force from its snapshots: the paper's intermediate model, with every
/// transition that displays sums of them.
///
/// Thread: the haptic loop's only.
class SnapshotRenderer final : public Renderer {
 public:
  /// Pre: !law_of(transition).gives_way.
  explicit SnapshotRenderer(display::Transition transition) : transition_(transition) {}

 private:
  void prepare(const TickScene& scene, bool is_other) noexcept override;
  void gather(const TickScene& scene, const proto::SnapshotHeader& latest,
              const collision::GridView& moving) noexcept override;
  void show(const TickScene& scene, const publication::SnapshotLook& look,
            RenderedTick& tick) noexcept override;

  struct Display {
    display::TransitionMemory memory;
    display::SnapshotWeights weights;
  };
  display::Transition transition_;
  Display shown_;           // of the last accepted snapshot, as it was displayed
  Display next_;            // being gathered, as are
  bool is_switch_ = false;  // from the snapshot right before it
  TouchedSpheres before_switch_;
  TouchedSpheres buffers_[2];
  TouchedSpheres* touched_ = &buffers_[0];  // of the last accepted read
  TouchedSpheres* fresh_ = &buffers_[1];    // being gathered
  ToolSweep sweep_;
  std::span<const PlacedToolSphere> tool_;  // of this tick
};

}  // namespace stillgrid::rendering
