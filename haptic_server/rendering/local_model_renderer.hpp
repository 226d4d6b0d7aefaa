#pragma once

#include <memory>
#include <utility>

#include "haptic_server/rendering/models/local_model.hpp"
#include "haptic_server/rendering/models/pose_history.hpp"
#include "haptic_server/rendering/renderer.hpp"

namespace stillgrid {

/// A patch is gathered as far from a tool sphere as this many of its radii.
inline constexpr double kPatchReach = 2.0;

/// Renders the scene's force from a model of what was near the tool: at each new image it gathers
/// the patch round the tool's pose that the image was computed with, as a slow process would hand
/// it over, and asks the model at each tick.
///
/// Thread: the haptic loop's only.
class LocalModelRenderer final : public Renderer {
 public:
  explicit LocalModelRenderer(std::unique_ptr<LocalModel> model) : model_(std::move(model)) {}

  [[nodiscard]] RenderedTick render(const SceneView& scene, const ToolPose& pose,
                                    std::uint64_t now_ns) noexcept override;

 private:
  ReadStatus read_image(const SceneView& scene, const PlacedTool& present) noexcept;

  std::unique_ptr<LocalModel> model_;
  std::uint64_t epoch_ = 0;           // of the segment that what follows came from
  proto::SnapshotHeader snapshot_{};  // that the model was made from
  PoseHistory poses_;
  TouchedSpheres buffers_[2];
  TouchedSpheres* patch_ = &buffers_[0];  // that the model was made from
  TouchedSpheres* fresh_ = &buffers_[1];  // being gathered
  ToolSpheres present_, balls_, sampled_;
};

}  // namespace stillgrid
