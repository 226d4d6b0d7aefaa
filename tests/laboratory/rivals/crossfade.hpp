#pragma once

#include <array>
#include <span>

#include "shared/rendering/placed_tool.hpp"
#include "shared/rendering/renderer.hpp"

namespace stillgrid::laboratory {

/// The force by the snapshot before passes to that by the latest over one period, each held and
/// felt where the tool now is [HAPI's interpolation of force effects, as H3D calls it: over the
/// last frame]. At a switch the mix before it is dropped for the snapshot before alone, so an early
/// snapshot jumps.
///
/// Thread: the haptic loop's only.
class CrossfadeRenderer final : public rendering::Renderer {
 private:
  void prepare(const rendering::TickScene& scene, bool is_other) noexcept override;
  void gather(const rendering::TickScene& scene, const proto::SnapshotHeader& latest,
              const collision::GridView& moving) noexcept override;
  void show(const rendering::TickScene& scene, const publication::SnapshotLook& look,
            rendering::RenderedTick& tick) noexcept override;

  using Snapshots = std::array<rendering::TouchedSpheres, 2>;  // the newest, and the one before
  Snapshots buffers_[2];
  Snapshots* touched_ = &buffers_[0];  // of the last accepted read
  Snapshots* fresh_ = &buffers_[1];    // being gathered
  double alpha_ = 1.0;                 // the last tick's
  bool is_switch_ = false;             // to the snapshot right after
  rendering::ToolSpheres placed_;
  std::span<const rendering::PlacedToolSphere> tool_;
};

}  // namespace stillgrid::laboratory
