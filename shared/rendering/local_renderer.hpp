#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "shared/rendering/local_copy.hpp"
#include "shared/rendering/snapshot_renderer.hpp"

namespace stillgrid::rendering {

/// Renders the force of the simulation as it is in this very tick. The simulation goes on here
/// along the path that the tool took (TickScene::local). `linear` shows the snapshots until the
/// copy has caught up, and in a scene without a copy. A switch between copies or snapshots changes
/// the force evenly over 0.1 s: a body that is gone lets go of the tool so.
///
/// Thread: the haptic loop's only. Realtime: as LocalScene.
class LocalRenderer final : public SnapshotRenderer {
 public:
  LocalRenderer() : SnapshotRenderer(display::Transition::kLinear) {}

 private:
  void prepare(const TickScene& scene, bool is_other) noexcept override;
  void gather(const TickScene& scene, const proto::SnapshotHeader& latest,
              const collision::GridView& moving) noexcept override;
  void show(const TickScene& scene, const publication::SnapshotLook& look,
            RenderedTick& tick) noexcept override;
  [[nodiscard]] dynamics::Wrench sum(const TickScene& scene, const publication::SnapshotLook& look,
                                     RenderedTick& tick) noexcept;
  [[nodiscard]] dynamics::Wrench sum_shown(const TickScene& scene,
                                           const publication::SnapshotLook& look,
                                           const std::optional<ToolForce>& as_before,
                                           RenderedTick& tick) noexcept;
  [[nodiscard]] dynamics::Wrench sum_given(const TickScene& scene,
                                           const publication::SnapshotLook& look,
                                           const std::optional<ToolForce>& as_before,
                                           RenderedTick& tick) noexcept;
  [[nodiscard]] dynamics::Wrench sum_simulated(const TickScene& scene,
                                               const std::optional<ToolForce>& as_before,
                                               RenderedTick& tick) noexcept;

  void ease(const dynamics::Wrench& change, std::uint64_t now_ns, ToolForce& force) noexcept;

  local::Advance now_;        // how the copy came to this tick
  bool was_local_ = false;    // in the tick before
  bool has_state_ = false;    // the gathered snapshot has one that the copy was not in
  bool lacks_state_ = false;  // the gathered snapshot is without state
  dynamics::Wrench eased_;    // change of the force by the last switch
  std::uint64_t eased_ns_ = 0;
};

}  // namespace stillgrid::rendering
