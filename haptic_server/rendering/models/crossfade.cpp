#include "haptic_server/rendering/models/crossfade.hpp"

#include <algorithm>
#include <utility>

namespace stillgrid {
namespace {

/// How far the force has passed to the image numbered `newest` in the history.
double progress(const proto::SnapshotHeader& snapshot, std::size_t newest, std::uint64_t now_ns) {
  const std::uint64_t switch_ns = snapshot.publish_time_ns[newest];
  const std::uint64_t before_ns = snapshot.publish_time_ns[newest + 1];
  if (snapshot.history_count <= newest + 1 || before_ns >= switch_ns) return 1.0;
  if (now_ns <= switch_ns) return 0.0;
  return std::min(
      1.0, static_cast<double>(now_ns - switch_ns) / static_cast<double>(switch_ns - before_ns));
}

ToolForce mixed(double share, const ToolForce& newest, const ToolForce& before) {
  return {share * newest.force_N + (1.0 - share) * before.force_N,
          share * newest.torque_N_m + (1.0 - share) * before.torque_N_m,
          std::max(newest.contacts, before.contacts),
          share * newest.stiffness_N_m + (1.0 - share) * before.stiffness_N_m};
}

}  // namespace

RenderedTick CrossfadeRenderer::render(const SceneView& scene, const ToolPose& pose,
                                       std::uint64_t now_ns) noexcept {
  if (epoch_ != scene.header().epoch) {
    epoch_ = scene.header().epoch;
    snapshot_ = {};
    for (TouchedSpheres& image : *touched_) image.clear();
  }
  const auto tool = place_tool(scene.scene(), pose, tool_);
  const std::uint64_t shown = snapshot_.generation;
  proto::SnapshotHeader snapshot{};
  const auto is_switch = [&] { return shown != 0 && snapshot.generation == shown + 1; };
  const ReadResult read = read_latest(scene.buffer(), [&](const std::uint64_t* payload) {
    snapshot = load_snapshot(payload);
    const GridView grid = scene.moving_grid(payload, snapshot);
    const auto gather = [&](std::size_t image, TouchedSpheres& touched) {
      touched.clear();
      gather_touched(grid, held_image(image), tool, touched);
    };
    gather(0, (*fresh_)[0]);
    gather(1, (*fresh_)[1]);
    if (is_switch()) gather(2, before_switch_);
  });
  if (read.status == ReadStatus::kEmpty && shown == 0) return {};
  const bool accepted = read.status == ReadStatus::kAccepted;
  const auto add_still = [&](TouchedSpheres& touched) {
    gather_touched(scene.static_grid(), held_image(0), tool, touched);
  };
  if (accepted) {
    for (TouchedSpheres& image : *fresh_) add_still(image);
    std::swap(touched_, fresh_);
    snapshot_ = snapshot;
  }
  const auto& [newest, before] = *touched_;
  RenderedTick tick = tick_showing(snapshot_, now_ns);
  tick.contended = !accepted;  // empty after an image: lost memory
  tick.is_new = snapshot_.generation != shown;
  tick.cut = newest.cut || before.cut;
  tick.alpha = progress(snapshot_, 0, now_ns);
  const auto force_by = [&](const TouchedSpheres& touched) {
    return tool_force(scene.scene(), touched, tool, pose);
  };
  const ToolForce by_before = force_by(before);
  tick.force = mixed(tick.alpha, force_by(newest), by_before);
  if (accepted && is_switch()) {
    add_still(before_switch_);
    const ToolForce old =
        mixed(progress(snapshot_, 1, now_ns), by_before, force_by(before_switch_));
    tick.switch_jump_N = (tick.force.force_N - old.force_N).norm();
  }
  return tick;
}

}  // namespace stillgrid
