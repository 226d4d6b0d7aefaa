#pragma once

#include <memory>
#include <span>
#include <utility>

#include "haptic_server/rendering/renderer.hpp"
#include "shared/tools/laboratory/rivals/local_model.hpp"
#include "shared/tools/laboratory/rivals/pose_history.hpp"

namespace stillgrid {

/// A patch is gathered as far from a tool sphere as this many of its radii.
inline constexpr double kPatchMargin = 2.0;

/// Renders the scene's force from a model of what was near the tool: at each new snapshot it
/// gathers the patch round the tool's pose that the snapshot was computed with, as a slow process
/// would hand it over, and asks the model at each tick.
///
/// Thread: the haptic loop's only.
class LocalModelRenderer final : public Renderer {
 public:
  explicit LocalModelRenderer(std::unique_ptr<LocalModel> model) : model_(std::move(model)) {}

 private:
  void prepare(const TickScene& scene, bool is_other) noexcept override;
  void gather(const TickScene& scene, const proto::SnapshotHeader& latest,
              const GridView& moving) noexcept override;
  void show(const TickScene& scene, const SnapshotLook& look, RenderedTick& tick) noexcept override;
  [[nodiscard]] ToolForce force(const TickScene& scene) noexcept;

  std::unique_ptr<LocalModel> model_;
  PoseHistory poses_;
  TouchedSpheres buffers_[2];
  TouchedSpheres* patch_ = &buffers_[0];  // that the model was made from
  TouchedSpheres* fresh_ = &buffers_[1];  // being gathered
  ToolSpheres placed_, placed_balls_;
  std::span<PlacedToolSphere> tool_, balls_;  // of this tick; in which a patch is gathered
  ToolForce before_;                          // by the model as the tick found it
};

}  // namespace stillgrid
