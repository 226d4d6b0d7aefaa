#include "tests/laboratory/rivals/crossfade.hpp"

#include <algorithm>
#include <utility>

namespace stillgrid::laboratory {
namespace {

/// How far the force has passed to the snapshot numbered `newest` in the history.
double progress(const proto::SnapshotHeader& snapshot, std::size_t newest, std::uint64_t now_ns) {
  const std::uint64_t switch_ns = snapshot.publish_time_ns[newest];
  const std::uint64_t before_ns = snapshot.publish_time_ns[newest + 1];
  if (snapshot.history_count <= newest + 1 || before_ns >= switch_ns) return 1.0;
  if (now_ns <= switch_ns) return 0.0;
  return std::min(
      1.0, static_cast<double>(now_ns - switch_ns) / static_cast<double>(switch_ns - before_ns));
}

rendering::ToolForce mixed(double share, const rendering::ToolForce& newest,
                           const rendering::ToolForce& before) {
  return {share * newest.force_N + (1.0 - share) * before.force_N,
          share * newest.torque_N_m + (1.0 - share) * before.torque_N_m,
          std::max(newest.contacts, before.contacts),
          share * newest.stiffness_N_per_m + (1.0 - share) * before.stiffness_N_per_m};
}

}  // namespace

void CrossfadeRenderer::prepare(const rendering::TickScene& scene, bool is_other) noexcept {
  if (is_other)
    for (rendering::TouchedSpheres& age : *touched_) age.clear();
  tool_ = rendering::place_tool(scene.fixed(), scene.pose, placed_);
  is_switch_ = false;
}

void CrossfadeRenderer::gather(const rendering::TickScene& scene,
                               const proto::SnapshotHeader& latest,
                               const collision::GridView& moving) noexcept {
  const auto gather_snapshot = [&](std::size_t age, rendering::TouchedSpheres& touched) {
    touched.clear();
    scene.gather_moving(moving, rendering::held_snapshot(age), tool_, touched);
  };
  gather_snapshot(0, (*fresh_)[0]);
  gather_snapshot(1, (*fresh_)[1]);
  is_switch_ = reader().has_snapshot() && latest.snapshot_id == reader().snapshot().snapshot_id + 1;
  if (is_switch_) gather_snapshot(2, before_switch_);
}

void CrossfadeRenderer::show(const rendering::TickScene& scene,
                             const publication::SnapshotLook& look,
                             rendering::RenderedTick& tick) noexcept {
  if (look.accepted()) {
    for (rendering::TouchedSpheres& age : *fresh_) scene.gather_static(tool_, age);
    std::swap(touched_, fresh_);
  }
  const proto::SnapshotHeader& snapshot = reader().snapshot();
  const auto& [newest, before] = *touched_;
  tick.truncated = newest.truncated || before.truncated;
  tick.weights.alpha = progress(snapshot, 0, scene.now_ns);
  const rendering::ToolForce by_before = scene.force_of(before, tool_);
  tick.force = mixed(tick.weights.alpha, scene.force_of(newest, tool_), by_before);
  if (!look.accepted() || !is_switch_) return;
  scene.gather_static(tool_, before_switch_);
  const rendering::ToolForce old =
      mixed(progress(snapshot, 1, scene.now_ns), by_before, scene.force_of(before_switch_, tool_));
  tick.switch_jump_N = (tick.force.force_N - old.force_N).norm();
}

}  // namespace stillgrid::laboratory
