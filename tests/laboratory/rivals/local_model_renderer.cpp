#include "tests/laboratory/rivals/local_model_renderer.hpp"

#include <limits>

namespace stillgrid::laboratory {
namespace {

/// Of the tool sample that a snapshot contains; none: the newest.
std::uint64_t sample_time_ns(const proto::SnapshotHeader& snapshot) {
  return snapshot.tool_time_ns != 0 ? snapshot.tool_time_ns
                                    : std::numeric_limits<std::uint64_t>::max();
}

}  // namespace

rendering::ToolForce LocalModelRenderer::force(const rendering::TickScene& scene) noexcept {
  return model_->force({.fixed = scene.fixed(), .patch = *patch_},
                       {scene.pose, tool_, scene.now_ns});
}

void LocalModelRenderer::prepare(const rendering::TickScene& scene, bool) noexcept {
  poses_.push(scene.now_ns, scene.pose);
  tool_ = rendering::place_tool(scene.fixed(), scene.pose, placed_);
  before_ = reader().has_snapshot() ? force(scene) : rendering::ToolForce{};
}

void LocalModelRenderer::gather(const rendering::TickScene& scene,
                                const proto::SnapshotHeader& latest,
                                const collision::GridView& moving) noexcept {
  if (latest.snapshot_id == reader().snapshot().snapshot_id) return;
  balls_ = rendering::place_tool(scene.fixed(), poses_.at(sample_time_ns(latest)), placed_balls_);
  for (rendering::PlacedToolSphere& ball : balls_) ball.radius_m *= kPatchMargin;
  if (reader().has_snapshot()) model_->widen(balls_);
  fresh_->clear();
  scene.gather_moving(moving, {}, balls_, *fresh_);
}

void LocalModelRenderer::show(const rendering::TickScene& scene,
                              const publication::SnapshotLook& look,
                              rendering::RenderedTick& tick) noexcept {
  tick.force = before_;
  if (look.is_new) {
    moving_ = fresh_->count;
    scene.gather_static(balls_, *fresh_);
    std::swap(patch_, fresh_);
    const rendering::ToolPose& pose = poses_.at(sample_time_ns(reader().snapshot()));
    rendering::ToolSpheres sampled;
    model_->update({scene.fixed(), *patch_, reader().snapshot().state_time_ns[0], moving_},
                   {pose, rendering::place_tool(scene.fixed(), pose, sampled)},
                   {scene.pose, tool_, scene.now_ns}, look.is_first);
    tick.force = force(scene);
    if (!look.is_first) tick.switch_jump_N = (tick.force.force_N - before_.force_N).norm();
  }
  tick.truncated = patch_->truncated;
}

}  // namespace stillgrid::laboratory
