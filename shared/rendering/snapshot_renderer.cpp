#include "shared/rendering/snapshot_renderer.hpp"

#include <utility>

namespace stillgrid::rendering {

void SnapshotRenderer::prepare(const TickScene& scene, bool is_other) noexcept {
  if (is_other) {
    touched_->clear();
    sweep_.forget();
  }
  tool_ = sweep_.place(scene.fixed(), scene.pose);
  is_switch_ = false;
}

void SnapshotRenderer::gather(const TickScene& scene, const proto::SnapshotHeader& latest,
                              const collision::GridView& moving) noexcept {
  const proto::SnapshotHeader& last = reader().snapshot();
  const bool is_first = !reader().has_snapshot();
  const std::uint64_t later = latest.snapshot_id - last.snapshot_id;
  next_.memory = is_first     ? display::at_first_snapshot()
                 : later == 0 ? shown_.memory
                              : display::after_switch(transition_, shown_.memory, last, latest);
  next_.weights = display::snapshot_weights(transition_, next_.memory, latest, scene.now_ns);
  const display::SnapshotWeights before =
      is_first ? next_.weights : display::in_later_snapshot(shown_.weights, later);
  fresh_->clear();
  scene.gather_moving(moving, {next_.weights, before}, tool_, *fresh_);
  is_switch_ = !is_first && later == 1;
  before_switch_.clear();
  if (!is_switch_) return;
  const display::SnapshotWeights old =
      display::snapshot_weights(transition_, shown_.memory, last, scene.now_ns);
  scene.gather_moving(moving, {display::in_later_snapshot(old, 1), before}, tool_, before_switch_);
}

void SnapshotRenderer::show(const TickScene& scene, const publication::SnapshotLook& look,
                            RenderedTick& tick) noexcept {
  if (look.accepted()) {
    shown_ = next_;
    scene.gather_static(tool_, *fresh_);
    std::swap(touched_, fresh_);
  } else {
    touched_->drop_swept();
  }
  tick.weights = shown_.weights;
  tick.truncated = touched_->truncated;
  tick.swept = touched_->has_swept();
  tick.force = scene.force_of(*touched_, tool_);
  if (!look.accepted()) return;
  if (is_switch_) {
    scene.gather_static(tool_, before_switch_);
    tick.switch_jump_N =
        (tick.force.force_N - scene.force_of(before_switch_, tool_).force_N).norm();
  }
  sweep_.end();  // what a contended tick did not look at the next one sweeps
}

}  // namespace stillgrid::rendering
