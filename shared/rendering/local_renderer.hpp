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

/// Renders the force of the simulation as it is in this very tick. The simulation goes on here
/// along the path that the tool took (local::LocalScene). The newest snapshot is shown as it is
/// until the copy has caught up, and where snapshots have no state.
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
    /// Returns the spheres and fields of the last show(). Valid until the next one.
    [[nodiscard]] collision::GridView view() const noexcept;

    local::LocalScene scene;
    publication::MovingRecords records;
    std::vector<double> positions_m, velocities_m_s;  // one a moving sphere
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
  std::vector<std::byte> state_;  // in the gathered snapshot; empty: it confirms the copy
  TouchedSpheres buffers_[2];
  TouchedSpheres* touched_ = &buffers_[0];  // the last tick's
  TouchedSpheres* fresh_ = &buffers_[1];    // being gathered
  ToolSweep sweep_;
  std::span<const PlacedToolSphere> tool_;  // this tick's
};

}  // namespace stillgrid::rendering
