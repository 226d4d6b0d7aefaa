#include "shared/rendering/local_renderer.hpp"

#include <algorithm>
#include <optional>
#include <tuple>
#include <variant>

#include "shared/display/stamps.hpp"

namespace stillgrid::rendering {
namespace {

std::uint64_t path_number(std::uint64_t now_ns) {
  return now_ns / proto::kPathTick_ns;
}

/// Ticks by which another hand's tool is led on. In virtual time its samples are complete: it is
/// led on between two of them alone.
std::uint64_t led_on_ticks(const proto::SegmentHeader& tool) {
  constexpr std::uint64_t kLongest = 100;  // then the simulation waits for it no longer
  if (tool.clock == proto::Clock::kMonotonic) return kLongest;
  const std::uint64_t period_ns = std::max<std::uint64_t>(tool.period_ns, 1);
  return std::min(kLongest, (period_ns - 1) / proto::kPathTick_ns);
}

template <class Local>
void follow_others(const TickScene& scene, Local& local) {
  for (std::size_t hand = 0; hand < local.hands(); ++hand) {
    if (hand == local.own_hand()) continue;
    const bool is_here = hand < scene.other_tools.size() && scene.other_tools[hand] != nullptr;
    if (!is_here) {
      local.leave(hand);
      continue;
    }
    const publication::ToolView& tool = *scene.other_tools[hand];
    local.follow(hand, tool.path(), led_on_ticks(tool.header()));
  }
}

}  // namespace

void LocalRenderer::prepare(const TickScene& scene, bool is_other) noexcept {
  SnapshotRenderer::prepare(scene, is_other);
  was_local_ = !is_other && now_.is_known;
  if (is_other) eased_ = {};
  now_ = {};
  if (scene.local == nullptr) return;
  const std::uint64_t tick = path_number(scene.now_ns);
  const dynamics::PathPose pose{
      {scene.pose.position_m, scene.pose.orientation, scene.pose.velocity_m_s}, tick};
  now_ = std::visit(
      [&](auto& local) {
        local.add_to_path(pose);
        follow_others(scene, local);
        return local.advance_to(tick);
      },
      scene.local->scene());
}

void LocalRenderer::gather(const TickScene& scene, const proto::SnapshotHeader& latest,
                           const collision::GridView& moving) noexcept {
  const bool is_new = latest.snapshot_id != reader().snapshot().snapshot_id;
  lacks_state_ =
      scene.local != nullptr && !scene.local->is_given() && is_new && latest.state_bytes == 0;
  has_state_ =
      scene.local != nullptr && is_new && latest.state_bytes > 0 &&
      !std::visit(
          [&](const auto& local) { return local.confirms(latest.state_tick, latest.state_hash); },
          scene.local->scene());
  if (has_state_) scene.view.copy_state(moving.words, latest, scene.local->loaded());
  if (!now_.is_known || lacks_state_ || scene.local->is_given())
    SnapshotRenderer::gather(scene, latest, moving);
}

void LocalRenderer::show(const TickScene& scene, const publication::SnapshotLook& look,
                         RenderedTick& tick) noexcept {
  if (look.accepted() && lacks_state_) {  // its ticks are too long there, or it is too large
    std::get<local::LocalScene>(scene.local->scene()).end();
    now_.is_known = false;
  }
  if (look.accepted() && has_state_)
    std::visit(
        [&](auto& local) {
          if (local.begin_at(reader().snapshot().state_tick, scene.local->loaded()))
            now_ += local.advance_to(path_number(scene.now_ns));
        },
        scene.local->scene());
  tick.is_local = now_.is_known;
  tick.local_ticks = now_.ticks;
  tick.is_swap = now_.is_swap;
  ease(sum(scene, look, tick), scene.now_ns, tick.force);
}

/// Sums the force of the copy, or of the snapshots where it does not know this tick. Returns the
/// change of the force that is to be eased.
dynamics::Wrench LocalRenderer::sum(const TickScene& scene, const publication::SnapshotLook& look,
                                    RenderedTick& tick) noexcept {
  const bool is_given = scene.local != nullptr && scene.local->is_given();
  const bool is_switch =
      now_.is_known ? now_.is_swap || !was_local_ : was_local_ || (look.is_new && !look.is_first);
  std::optional<ToolForce> as_before;
  if (is_switch && (look.accepted() || (now_.is_known && !is_given)))
    as_before = force_of_last(scene);
  if (now_.is_known)
    tick.age_s =
        display::seconds_between(path_number(scene.now_ns) * proto::kPathTick_ns, scene.now_ns);
  if (now_.is_known && !is_given) return sum_simulated(scene, as_before, tick);
  const dynamics::Wrench change = now_.is_known ? sum_given(scene, look, as_before, tick)
                                                : sum_shown(scene, look, as_before, tick);
  // Switches between snapshots are as they are. Bodies that a publisher gives have offsets.
  const bool is_eased = !now_.is_known && was_local_ && scene.local != nullptr && !is_given;
  return is_eased ? change : dynamics::Wrench{};
}

dynamics::Wrench LocalRenderer::sum_shown(const TickScene& scene,
                                          const publication::SnapshotLook& look,
                                          const std::optional<ToolForce>& as_before,
                                          RenderedTick& tick) noexcept {
  accept_weights(look, tick);
  return sum_force(scene, look.accepted(), as_before, tick);
}

/// Sums the force of a publisher's bodies.
dynamics::Wrench LocalRenderer::sum_given(const TickScene& scene,
                                          const publication::SnapshotLook& look,
                                          const std::optional<ToolForce>& as_before,
                                          RenderedTick& tick) noexcept {
  auto& copy = std::get<local::GivenScene>(scene.local->scene());
  begin_at(copy.own_proxies_m(), false);
  if (look.accepted()) scene.local->replace(reach(), fresh());
  TickScene shown = scene;
  shown.stretches_m = copy.own_stretches_m();
  return sum_shown(shown, look, as_before, tick);
}

/// Sums the force of the simulation's bodies.
dynamics::Wrench LocalRenderer::sum_simulated(const TickScene& scene,
                                              const std::optional<ToolForce>& as_before,
                                              RenderedTick& tick) noexcept {
  const auto& copy = std::get<local::LocalScene>(scene.local->scene());
  begin_at(copy.own_proxies_m(), true);
  scene.local->show();
  fresh().clear();
  scene.gather_moving(scene.local->view(), {}, reach(), fresh());
  // The grid's order depends on what was displayed before; that of fields does not.
  std::sort(fresh().spheres.begin(), fresh().spheres.begin() + std::ssize(fresh().all()),
            [](const TouchedSphere& a, const TouchedSphere& b) {
              return std::tie(a.tool_sphere, a.field, a.number) <
                     std::tie(b.tool_sphere, b.field, b.number);
            });
  TickScene shown = scene;
  shown.stretches_m = copy.own_stretches_m();
  return sum_force(shown, true, as_before, tick);
}

/// Adds what is left of the changes by switches. It decays evenly.
void LocalRenderer::ease(const dynamics::Wrench& change, std::uint64_t now_ns,
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
