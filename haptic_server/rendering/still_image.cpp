#include "haptic_server/rendering/still_image.hpp"

#include <utility>

namespace stillgrid {

RenderedTick StillImageRenderer::render(const SceneView& scene, const ToolPose& pose,
                                        std::uint64_t now_ns) noexcept {
  if (epoch_ != scene.header().epoch) {
    epoch_ = scene.header().epoch;
    snapshot_ = {};
    touched_->clear();
    tool_.forget();
  }
  const auto tool = tool_.place(scene.scene(), pose);

  proto::SnapshotHeader snapshot{};
  TransitionMemory memory;
  DisplayedMotion shown;
  bool is_switch = false;
  const ReadResult read = read_latest(scene.buffer(), [&](const std::uint64_t* payload) {
    snapshot = load_snapshot(payload);
    const bool is_first = snapshot_.generation == 0;
    const std::uint64_t later = snapshot.generation - snapshot_.generation;
    memory = is_first     ? at_first_image()
             : later == 0 ? memory_
                          : after_switch(transition_, memory_, snapshot_, snapshot);
    shown.now = image_weights(transition_, memory, snapshot, now_ns);
    shown.before = is_first ? shown.now : in_later_image(weights_, later);
    const GridView grid = scene.moving_grid(payload, snapshot);
    fresh_->clear();
    gather_touched(grid, shown, tool, *fresh_);
    is_switch = !is_first && later == 1;
    before_switch_.clear();
    if (is_switch) {
      const ImageWeights old = image_weights(transition_, memory_, snapshot_, now_ns);
      gather_touched(grid, {in_later_image(old, 1), shown.before}, tool, before_switch_);
    }
  });

  const bool had_image = snapshot_.generation != 0;
  if (read.status == ReadStatus::kEmpty && !had_image) return {};
  const bool contended = read.status != ReadStatus::kAccepted;  // empty after one: lost memory
  const bool is_new = !contended && snapshot.generation != snapshot_.generation;
  if (contended) {
    touched_->drop_swept();
  } else {
    snapshot_ = snapshot;
    memory_ = memory;
    weights_ = shown.now;
    gather_touched(scene.static_grid(), held_image(0), tool, *fresh_);
    std::swap(touched_, fresh_);
  }
  RenderedTick tick = tick_showing(snapshot_, now_ns);
  tick.contended = contended;
  tick.is_new = is_new;
  tick.weights = weights_;
  tick.alpha = weights_.alpha;
  tick.stands = weights_.stands;
  tick.cut = touched_->cut;
  for (const TouchedSphere& sphere : touched_->all()) tick.swept = tick.swept || sphere.swept;
  tick.force = tool_force(scene.scene(), *touched_, tool, pose);
  if (is_switch && !contended) {
    gather_touched(scene.static_grid(), held_image(0), tool, before_switch_);
    const ToolForce old = tool_force(scene.scene(), before_switch_, tool, pose);
    tick.switch_jump_N = (tick.force.force_N - old.force_N).norm();
  }
  // What a contended tick did not look at is the next one's way.
  if (!contended) tool_.end();
  return tick;
}

}  // namespace stillgrid
