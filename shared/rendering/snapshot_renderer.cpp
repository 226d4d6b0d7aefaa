#include "shared/rendering/snapshot_renderer.hpp"

#include <utility>

namespace stillgrid::rendering {

void SnapshotRenderer::prepare(const TickScene& scene, bool is_other) noexcept {
  if (is_other) {
    touched_->clear();
    sweep_.forget();
  }
  tool_ = sweep_.place(scene.fixed(), scene.pose);
}

void SnapshotRenderer::gather(const TickScene& scene, const proto::SnapshotHeader& latest,
                              const collision::GridView& moving) noexcept {
  next_ = display::snapshot_weights(transition_, latest, scene.now_ns);
  const display::SnapshotWeights before =
      reader().has_snapshot()
          ? display::in_later_snapshot(shown_, latest.snapshot_id - reader().snapshot().snapshot_id)
          : next_;
  fresh_->clear();
  scene.gather_moving(moving, {next_, before}, tool_, *fresh_);
}

void SnapshotRenderer::accept_weights(const publication::SnapshotLook& look,
                                      RenderedTick& tick) noexcept {
  if (look.accepted()) shown_ = next_;
  tick.weights = shown_;
}

void SnapshotRenderer::show(const TickScene& scene, const publication::SnapshotLook& look,
                            RenderedTick& tick) noexcept {
  accept_weights(look, tick);
  sum_force(scene, look.accepted(), look.is_new && !look.is_first, tick);
}

void SnapshotRenderer::sum_force(const TickScene& scene, bool is_seen, bool is_switch,
                                 RenderedTick& tick) noexcept {
  touched_->drop_swept();
  ToolForce as_before;
  if (is_seen) {
    scene.gather_static(tool_, *fresh_);
    std::swap(touched_, fresh_);
    if (is_switch) as_before = scene.force_of(*fresh_, tool_);
  }
  tick.truncated = touched_->truncated;
  tick.swept = touched_->has_swept();
  tick.force = scene.force_of(*touched_, tool_);
  if (!is_seen) return;
  if (is_switch) tick.switch_jump_N = (tick.force.force_N - as_before.force_N).norm();
  sweep_.end();  // what a contended tick did not look at the next one sweeps
}

}  // namespace stillgrid::rendering
