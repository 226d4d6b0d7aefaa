#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "haptic_server/rendering/renderer.hpp"
#include "haptic_server/rendering/tool_way.hpp"
#include "haptic_server/rendering/touched_spheres.hpp"
#include "haptic_server/rendering/transition.hpp"
#include "shared/publication/scene_segment.hpp"

namespace stillgrid {

/// Renders the force of the transition `answer`: the newest image led on by the simulation's own
/// next step, for the hand where it is now (docs/algorithms/predict.md).
///
/// Each tick finds the one change of the tool's force to which the spheres yield so that they
/// exert it. What an image shows otherwise than was displayed is ramped out, as a shift of the
/// spheres over half a period, and the little that this leaves of the force within 3 ms.
/// Thread: the haptic loop's only.
class AnswerRenderer final : public Renderer {
 public:
  [[nodiscard]] RenderedTick render(const SceneView& scene, const ToolPose& pose,
                                    std::uint64_t now_ns) noexcept override;

 private:
  /// An image as it is displayed.
  struct Shown {
    proto::SnapshotHeader snapshot{};
    ImageWeights weights;
    std::uint64_t began_ns = 0;                         // the first tick that displayed it
    double change_N = 0.0;                              // as the last tick solved it
    Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  // when it came
    Eigen::Vector3d rest_N = Eigen::Vector3d::Zero();   // likewise
    Eigen::Vector3d rest_N_m = Eigen::Vector3d::Zero();
  };
  [[nodiscard]] Yielding yielding(const Shown& shown, std::uint64_t now_ns) const noexcept;
  /// What is left of the rest of the force that the image came with.
  [[nodiscard]] Eigen::Vector3d rest_N(std::uint64_t now_ns) const noexcept;
  ToolForce last_image_force(const SceneView& scene, std::span<const PlacedToolSphere> tool,
                             const ToolPose& pose, std::uint64_t now_ns) noexcept;
  void continue_from(const GridView& grid, double push_N, std::span<const PlacedToolSphere> tool,
                     std::uint64_t now_ns, Shown& next) const noexcept;

  std::uint64_t epoch_ = 0;    // of the segment that what follows came from
  std::uint64_t tick_ns_ = 0;  // of the last tick
  Shown shown_;                // by the last accepted read
  TouchedSpheres buffers_[2];
  TouchedSpheres* touched_ = &buffers_[0];  // moving ones, of the last accepted read
  TouchedSpheres* fresh_ = &buffers_[1];    // being gathered
  TouchedSpheres still_;                    // of the static grid
  ToolWay tool_;
  double radius_m_ = 0.0;  // the largest of the tool's
};

}  // namespace stillgrid
