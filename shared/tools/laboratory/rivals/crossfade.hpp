#pragma once

#include <array>
#include <span>

#include "haptic_server/rendering/placed_tool.hpp"
#include "haptic_server/rendering/renderer.hpp"

namespace stillgrid {

/// The force by the snapshot before passes to that by the latest over one period, each held and
/// felt where the tool now is [HAPI's interpolation of force effects, as H3D calls it: over the
/// last frame]. At a switch the mix before it is dropped for the snapshot before alone, so an early
/// snapshot jumps.
///
/// Thread: the haptic loop's only.
class CrossfadeRenderer final : public Renderer {
 private:
  void prepare(const TickScene& scene, bool is_other) noexcept override;
  void gather(const TickScene& scene, const proto::SnapshotHeader& latest,
              const GridView& moving) noexcept override;
  void show(const TickScene& scene, const SnapshotLook& look, RenderedTick& tick) noexcept override;

  using Snapshots = std::array<TouchedSpheres, 2>;  // the newest, and the one before
  Snapshots buffers_[2];
  Snapshots* touched_ = &buffers_[0];  // of the last accepted read
  Snapshots* fresh_ = &buffers_[1];    // being gathered
  TouchedSpheres before_switch_;       // in the snapshot before the one before
  bool is_switch_ = false;             // to the snapshot right after
  ToolSpheres placed_;
  std::span<const PlacedToolSphere> tool_;
};

}  // namespace stillgrid
