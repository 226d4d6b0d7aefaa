#pragma once

#include <span>

#include "shared/rendering/placed_tool.hpp"
#include "shared/rendering/renderer.hpp"
#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::rendering {

/// Renders the scene's force from its snapshots: the paper's intermediate model.
///
/// Thread: the haptic loop's only.
class SnapshotRenderer : public Renderer {
 public:
  explicit SnapshotRenderer(display::Transition transition) : transition_(transition) {}

 protected:
  void prepare(const TickScene& scene, bool is_other) noexcept override;
  void gather(const TickScene& scene, const proto::SnapshotHeader& latest,
              const collision::GridView& moving) noexcept override;
  void show(const TickScene& scene, const publication::SnapshotLook& look,
            RenderedTick& tick) noexcept override;

  /// How the gathered snapshot is displayed counts from now on, if its read does.
  void accept_weights(const publication::SnapshotLook& look, RenderedTick& tick) noexcept;
  [[nodiscard]] std::span<const PlacedToolSphere> tool() const noexcept { return tool_; }
  /// The moving spheres that the tool touches in this tick, being gathered.
  [[nodiscard]] TouchedSpheres& fresh() noexcept { return *fresh_; }
  /// Sums the force of fresh() and of the static spheres. The last tick's spheres stand if the
  /// scene was not seen. is_switch: the displayed scene has another source than in the last tick.
  void sum_force(const TickScene& scene, bool is_seen, bool is_switch, RenderedTick& tick) noexcept;

 private:
  display::Transition transition_;
  display::SnapshotWeights shown_;  // the last accepted snapshot's
  display::SnapshotWeights next_;   // being gathered
  TouchedSpheres buffers_[2];
  TouchedSpheres* touched_ = &buffers_[0];  // the last accepted read's
  TouchedSpheres* fresh_ = &buffers_[1];
  ToolSweep sweep_;
  std::span<const PlacedToolSphere> tool_;  // this tick's
};

}  // namespace stillgrid::rendering
