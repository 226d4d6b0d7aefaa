#include "shared/rendering/snapshot_renderer.hpp"

#include <optional>
#include <utility>

#include "shared/display/stamps.hpp"
#include "shared/local/given_state.hpp"

namespace stillgrid::rendering {

void SnapshotRenderer::prepare(const TickScene& scene, bool is_other) noexcept {
  if (is_other) {
    touched_->clear();
    proxies_.forget();
  }
  // Bodies of sim_server neither come nor go.
  const bool is_published = scene.view.model().empty() || local::is_given_model(scene.view.model());
  proxies_.place(scene.fixed(), scene.pose, is_published);
}

void SnapshotRenderer::gather(const TickScene& scene, const proto::SnapshotHeader& latest,
                              const collision::GridView& moving) noexcept {
  next_ = display::snapshot_weights(transition_, latest, scene.now_ns);
  fresh_->clear();
  scene.gather_moving(moving, next_, reach(), *fresh_);
}

void SnapshotRenderer::accept_weights(const publication::SnapshotLook& look,
                                      RenderedTick& tick) noexcept {
  if (look.accepted()) shown_ = next_;
  tick.weights = shown_;
}

void SnapshotRenderer::show(const TickScene& scene, const publication::SnapshotLook& look,
                            RenderedTick& tick) noexcept {
  accept_weights(look, tick);
  std::optional<ToolForce> as_before;
  if (look.accepted() && look.is_new && !look.is_first) as_before = force_of_last(scene);
  sum_force(scene, look.accepted(), as_before, tick);
}

double SnapshotRenderer::tick_s(const TickScene& scene) const noexcept {
  return pressed_ns_ == 0 ? 0.0 : display::seconds_between(pressed_ns_, scene.now_ns);
}

ToolForce SnapshotRenderer::force_of_last(const TickScene& scene) noexcept {
  return proxies_.force_of(scene.fixed(), *touched_, scene.pose, tick_s(scene));
}

dynamics::Wrench SnapshotRenderer::sum_force(const TickScene& scene, bool is_seen,
                                             const std::optional<ToolForce>& as_before,
                                             RenderedTick& tick) noexcept {
  if (is_seen) {
    scene.gather_static(reach(), *fresh_);
    std::swap(touched_, fresh_);
  }
  tick.truncated = touched_->truncated;
  tick.force =
      proxies_.press(scene.fixed(), *touched_, scene.pose, tick_s(scene), scene.stretches_m);
  pressed_ns_ = scene.now_ns;
  if (!as_before) return {};
  const dynamics::Wrench change{as_before->force_N - tick.force.force_N,
                                as_before->torque_N_m - tick.force.torque_N_m};
  tick.switch_jump_N = change.force_N.norm();
  return change;
}

}  // namespace stillgrid::rendering
