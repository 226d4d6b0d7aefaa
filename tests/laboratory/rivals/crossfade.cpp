#include "tests/laboratory/rivals/crossfade.hpp"

#include <algorithm>
#include <utility>

namespace stillgrid::laboratory {
namespace {

/// How far the force has passed to the newest snapshot.
double progress(const proto::SnapshotHeader& snapshot, std::uint64_t now_ns) {
  const auto [switch_ns, before_ns] = snapshot.publish_time_ns;
  if (snapshot.history_count < 2 || before_ns >= switch_ns) return 1.0;
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
  const auto gather_snapshot = [&](double alpha, rendering::TouchedSpheres& touched) {
    touched.clear();
    scene.gather_moving(moving, {.alpha = alpha}, tool_, touched);
  };
  gather_snapshot(1.0, (*fresh_)[0]);
  gather_snapshot(0.0, (*fresh_)[1]);
  is_switch_ = reader().has_snapshot() && latest.snapshot_id == reader().snapshot().snapshot_id + 1;
}

void CrossfadeRenderer::show(const rendering::TickScene& scene,
                             const publication::SnapshotLook& look,
                             rendering::RenderedTick& tick) noexcept {
  const auto force = [&] {
    return mixed(alpha_, rendering::tool_force(scene.fixed(), (*touched_)[0], tool_, scene.pose),
                 rendering::tool_force(scene.fixed(), (*touched_)[1], tool_, scene.pose));
  };
  const rendering::ToolForce as_before = force();
  if (look.accepted()) {
    for (rendering::TouchedSpheres& age : *fresh_) scene.gather_static(tool_, age);
    std::swap(touched_, fresh_);
  }
  alpha_ = progress(reader().snapshot(), scene.now_ns);
  tick.truncated = (*touched_)[0].truncated || (*touched_)[1].truncated;
  tick.weights.alpha = alpha_;
  tick.force = force();
  if (look.accepted() && is_switch_)
    tick.switch_jump_N = (tick.force.force_N - as_before.force_N).norm();
}

}  // namespace stillgrid::laboratory
