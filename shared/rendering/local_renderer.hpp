#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "shared/display/transition.hpp"
#include "shared/local/local_scene.hpp"
#include "shared/publication/moving_records.hpp"
#include "shared/rendering/placed_tool.hpp"
#include "shared/rendering/renderer.hpp"
#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::rendering {

/// Renders the force of the simulation as it is in this very tick: it goes on here from the newest
/// snapshot along the path that the tool took (local::LocalScene). Until it has caught up, and of
/// a scene whose snapshots have no state, it shows the newest snapshot as it is.
///
/// Thread: the haptic loop's only. Realtime: allocates when the scene is another, and when it loads
/// a state.
class LocalRenderer final : public Renderer {
 public:
  LocalRenderer() = default;

 private:
  /// A scene's copy and its spheres, as a grid that the tool is looked up in.
  struct Local {
    explicit Local(const publication::SceneView& view);
    void show_spheres();

    local::LocalScene scene;
    publication::MovingRecords records;
    std::vector<double> positions_m, velocities_m_s;  // of moving spheres
  };
  void prepare(const TickScene& scene, bool is_other) noexcept override;
  void gather(const TickScene& scene, const proto::SnapshotHeader& latest,
              const collision::GridView& moving) noexcept override;
  void show(const TickScene& scene, const publication::SnapshotLook& look,
            RenderedTick& tick) noexcept override;

  std::optional<Local> local_;
  bool is_local_ = false;         // the copy is at this tick
  std::vector<std::byte> state_;  // of the snapshot that is gathered; empty: nothing to load
  TouchedSpheres buffers_[2];
  TouchedSpheres* touched_ = &buffers_[0];  // of the last tick
  TouchedSpheres* fresh_ = &buffers_[1];    // being gathered
  ToolSweep sweep_;
  std::span<const PlacedToolSphere> tool_;  // of this tick
};

}  // namespace stillgrid::rendering
