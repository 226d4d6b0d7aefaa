#include "shared/rendering/snapshot_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "shared/collision/grid_query.hpp"
#include "shared/display/stamps.hpp"
#include "shared/local/given_state.hpp"

namespace stillgrid::rendering {

void SnapshotRenderer::prepare(const TickScene& scene, bool is_other) noexcept {
  if (is_other) {
    touched_->clear();
    proxies_.forget();
    eased_ = {};
  }
  lost_a_pusher_ = false;
  proxies_.place(scene.fixed(), scene.pose);
}

namespace {

/// Whether the newest snapshot of a grid has the sphere.
bool has(const collision::GridView& moving, const ToolProxies::Pusher& pusher) noexcept {
  if (pusher.number >= moving.shape.sphere_count) return false;
  const proto::SphereRecord record = collision::load_record(moving, pusher.number);
  return record.body == pusher.body && record.radius_m == pusher.radius_m &&
         !std::isnan(record.newest.position_m[0]);
}

}  // namespace

void SnapshotRenderer::gather(const TickScene& scene, const proto::SnapshotHeader& latest,
                              const collision::GridView& moving) noexcept {
  next_ = display::snapshot_weights(transition_, latest, scene.now_ns);
  // Bodies of sim_server neither come nor go.
  const bool may_lose = scene.view.model().empty() || local::is_given_model(scene.view.model());
  lost_a_pusher_ = may_lose && std::ranges::any_of(proxies_.pushers(), [&](const auto& pusher) {
                     return !has(moving, pusher);
                   });
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
  const bool is_switch = look.is_new && !look.is_first;
  if (look.accepted() && (is_switch || lost_a_pusher_)) as_before = force_of_last(scene);
  const dynamics::Wrench change = sum_force(scene, look.accepted(), as_before, tick);
  ease(lost_a_pusher_ ? change : dynamics::Wrench{}, scene.now_ns, tick.force);
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

void SnapshotRenderer::ease(const dynamics::Wrench& change, std::uint64_t now_ns,
                            ToolForce& force) noexcept {
  constexpr double kEased_s = 0.1;
  double share = std::max(0.0, 1.0 - display::seconds_between(eased_ns_, now_ns) / kEased_s);
  if (change.force_N != Eigen::Vector3d::Zero() || change.torque_N_m != Eigen::Vector3d::Zero()) {
    eased_ = {share * eased_.force_N + change.force_N,
              share * eased_.torque_N_m + change.torque_N_m};
    eased_ns_ = now_ns;
    share = 1.0;
  }
  force.force_N += share * eased_.force_N;
  force.torque_N_m += share * eased_.torque_N_m;
}

}  // namespace stillgrid::rendering
