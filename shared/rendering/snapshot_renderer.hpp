#pragma once

#include <optional>
#include <span>

#include "shared/dynamics/wrench.hpp"
#include "shared/rendering/renderer.hpp"
#include "shared/rendering/tool_proxies.hpp"
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
  /// The spheres to gather with in this tick.
  [[nodiscard]] std::span<const PlacedToolSphere> reach() const noexcept {
    return proxies_.reach();
  }
  /// The moving spheres near the tool in this tick, being gathered.
  [[nodiscard]] TouchedSpheres& fresh() noexcept { return *fresh_; }
  /// Returns the force of the last tick's spheres on the tool where it is now.
  [[nodiscard]] ToolForce force_of_last(const TickScene& scene) noexcept;
  /// Goes on with the proxies of a simulation. See ToolProxies::begin_at().
  void begin_at(std::span<const dynamics::Vector4> proxies_m, bool knows_all) noexcept {
    proxies_.begin_at(proxies_m, knows_all);
  }
  /// Sums the force of fresh() and of the static spheres. The last tick's spheres stand if the
  /// scene was not seen. as_before: force_of_last(), if the displayed scene has another source than
  /// in the last tick. Returns by how much larger it is.
  dynamics::Wrench sum_force(const TickScene& scene, bool is_seen,
                             const std::optional<ToolForce>& as_before,
                             RenderedTick& tick) noexcept;

 private:
  [[nodiscard]] double tick_s(const TickScene& scene) const noexcept;

  display::Transition transition_;
  display::SnapshotWeights shown_;  // the last accepted snapshot's
  display::SnapshotWeights next_;   // being gathered
  TouchedSpheres buffers_[2];
  TouchedSpheres* touched_ = &buffers_[0];  // the last accepted read's
  TouchedSpheres* fresh_ = &buffers_[1];
  ToolProxies proxies_;
  std::uint64_t pressed_ns_ = 0;  // the tick before
};

}  // namespace stillgrid::rendering
