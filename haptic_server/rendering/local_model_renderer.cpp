#include "haptic_server/rendering/local_model_renderer.hpp"

#include <limits>

namespace stillgrid {
namespace {

/// Of the tool sample that an image contains; none: the newest.
std::uint64_t sample_time_ns(const proto::SnapshotHeader& snapshot) {
  return snapshot.tool_time_ns != 0 ? snapshot.tool_time_ns
                                    : std::numeric_limits<std::uint64_t>::max();
}

}  // namespace

/// Makes the model anew if there is a newer image.
ReadStatus LocalModelRenderer::read_image(const SceneView& scene,
                                          const PlacedTool& present) noexcept {
  const bool is_first = snapshot_.generation == 0;
  proto::SnapshotHeader snapshot{};
  std::span<PlacedToolSphere> balls;
  const ReadResult read = read_latest(scene.buffer(), [&](const std::uint64_t* payload) {
    snapshot = load_snapshot(payload);
    if (snapshot.generation == snapshot_.generation) return;
    balls = place_tool(scene.scene(), poses_.at(sample_time_ns(snapshot)), balls_);
    for (PlacedToolSphere& ball : balls) ball.radius_m *= kPatchReach;
    if (!is_first) model_->widen(balls);
    fresh_->clear();
    gather_touched(scene.moving_grid(payload, snapshot), held_image(0), balls, *fresh_);
  });
  if (read.status != ReadStatus::kAccepted || snapshot.generation == snapshot_.generation)
    return read.status;

  gather_touched(scene.static_grid(), held_image(0), balls, *fresh_);
  std::swap(patch_, fresh_);
  snapshot_ = snapshot;
  const ToolPose& pose = poses_.at(sample_time_ns(snapshot));
  model_->update({scene.scene(), *patch_}, {pose, place_tool(scene.scene(), pose, sampled_)},
                 present, is_first);
  return read.status;
}

RenderedTick LocalModelRenderer::render(const SceneView& scene, const ToolPose& pose,
                                        std::uint64_t now_ns) noexcept {
  if (epoch_ != scene.header().epoch) {
    epoch_ = scene.header().epoch;
    snapshot_ = {};
  }
  poses_.push(now_ns, pose);
  const PlacedTool tool{pose, place_tool(scene.scene(), pose, present_), now_ns};
  const auto force = [&] { return model_->force({scene.scene(), *patch_}, tool); };

  const std::uint64_t shown = snapshot_.generation;
  const ToolForce before = shown != 0 ? force() : ToolForce{};
  const ReadStatus status = read_image(scene, tool);
  if (status == ReadStatus::kEmpty && shown == 0) return {};
  RenderedTick tick = tick_showing(snapshot_, now_ns);
  tick.contended = status != ReadStatus::kAccepted;  // empty after an image: lost memory
  tick.is_new = snapshot_.generation != shown;
  tick.cut = patch_->cut;
  tick.force = tick.is_new ? force() : before;
  if (tick.is_new && shown != 0) tick.switch_jump_N = (tick.force.force_N - before.force_N).norm();
  return tick;
}

}  // namespace stillgrid
