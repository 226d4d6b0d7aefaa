#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "shared/display/transition.hpp"
#include "shared/local/local_scene.hpp"
#include "shared/publication/moving_fields.hpp"
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
  /// A scene's copy, and its spheres and fields as a slot would have them.
  struct Local {
    explicit Local(const publication::SceneView& view);
    /// Shows the scene of this tick. Realtime: yes, but where spheres are entered anew.
    void show();
    /// What was shown last. Valid until the next show().
    [[nodiscard]] collision::GridView view() const noexcept;

    local::LocalScene scene;
    publication::MovingRecords records;
    std::vector<double> positions_m, velocities_m_s;  // of moving spheres
    publication::MovingFields fields;
    std::vector<std::uint64_t> field_words;  // the same records as words

   private:
    void show_spheres();
    void show_fields() noexcept;
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
