#pragma once

#include <memory>
#include <span>
#include <utility>

#include "shared/rendering/renderer.hpp"
#include "tests/laboratory/rivals/local_model.hpp"
#include "tests/laboratory/rivals/pose_history.hpp"

namespace stillgrid::laboratory {

/// A patch is gathered as far from a tool sphere as this many of its radii.
inline constexpr double kPatchMargin = 2.0;

/// Renders the scene's force from a model of what was near the tool: at each new snapshot it
/// gathers the patch round the tool's pose that the snapshot was computed with, as a slow process
/// would hand it over, and asks the model at each tick.
///
/// Thread: the haptic loop's only.
class LocalModelRenderer : public rendering::Renderer {
 public:
  explicit LocalModelRenderer(std::unique_ptr<LocalModel> model) : model_(std::move(model)) {}

 private:
  void prepare(const rendering::TickScene& scene, bool is_other) noexcept override;
  void gather(const rendering::TickScene& scene, const proto::SnapshotHeader& latest,
              const collision::GridView& moving) noexcept override;
  void show(const rendering::TickScene& scene, const publication::SnapshotLook& look,
            rendering::RenderedTick& tick) noexcept override;
  [[nodiscard]] rendering::ToolForce force(const rendering::TickScene& scene) noexcept;

  std::unique_ptr<LocalModel> model_;
  PoseHistory poses_;
  rendering::TouchedSpheres buffers_[2];
  rendering::TouchedSpheres* patch_ = &buffers_[0];  // that the model was made from
  rendering::TouchedSpheres* fresh_ = &buffers_[1];  // being gathered
  std::size_t moving_ = 0;                           // of them that are of bodies that move
  rendering::ToolSpheres placed_, placed_balls_;
  std::span<rendering::PlacedToolSphere> tool_,
      balls_;                    // of this tick; in which a patch is gathered
  rendering::ToolForce before_;  // by the model as the tick found it
};

}  // namespace stillgrid::laboratory
