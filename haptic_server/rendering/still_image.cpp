#include "haptic_server/rendering/still_image.hpp"

#include <utility>

namespace stillgrid {
namespace {

double seconds_since(std::uint64_t then_ns, std::uint64_t now_ns) {
  return now_ns > then_ns ? static_cast<double>(now_ns - then_ns) * 1e-9 : 0.0;
}

}  // namespace

std::span<PlacedToolSphere> StillImageRenderer::place(const proto::SceneHeader& scene,
                                                      const ToolPose& tool) {
  for (std::uint32_t i = 0; i < scene.tool_sphere_count; ++i) {
    const auto& p = scene.tool[i].position_m;
    tool_[i].position_m = tool.position_m + tool.orientation * Eigen::Vector3d(p[0], p[1], p[2]);
    tool_[i].radius_m = static_cast<double>(scene.tool[i].radius_m);
    if (!has_way_) tool_[i].before_m = tool_[i].position_m;
  }
  return {tool_.data(), scene.tool_sphere_count};
}

RenderedTick StillImageRenderer::render(const SceneView& scene, const ToolPose& pose,
                                        std::uint64_t now_ns) noexcept {
  if (epoch_ != scene.header().epoch) {
    epoch_ = scene.header().epoch;
    snapshot_ = {};
    touched_->clear();
    has_way_ = false;
  }
  const auto tool = place(scene.scene(), pose);

  proto::SnapshotHeader snapshot{};
  DisplayedMotion shown;
  bool is_switch = false;
  const ReadResult read = read_latest(scene.buffer(), [&](const std::uint64_t* payload) {
    snapshot = load_snapshot(payload);
    shown.now = image_weights(transition_, snapshot, now_ns);
    shown.before = snapshot_.generation == 0
                       ? shown.now
                       : in_later_image(weights_, snapshot.generation - snapshot_.generation);
    const GridView grid = scene.moving_grid(payload, snapshot);
    fresh_->clear();
    gather_touched(grid, shown, tool, *fresh_);
    is_switch = snapshot_.generation != 0 && snapshot.generation == snapshot_.generation + 1;
    before_switch_.clear();
    if (is_switch) {
      const ImageWeights old = weights_before_switch(transition_, snapshot, now_ns);
      gather_touched(grid, {old, shown.before}, tool, before_switch_);
    }
  });

  RenderedTick tick;
  const bool had_image = snapshot_.generation != 0;
  if (read.status == ReadStatus::kEmpty && !had_image) return tick;
  tick.contended = read.status != ReadStatus::kAccepted;  // empty after an image: lost memory
  const ImageWeights still = image_weights(Transition::kHold, snapshot, now_ns);
  if (tick.contended) {
    touched_->drop_swept();
  } else {
    tick.is_new = snapshot.generation != snapshot_.generation;
    snapshot_ = snapshot;
    weights_ = shown.now;
    gather_touched(scene.static_grid(), {still, still}, tool, *fresh_);
    std::swap(touched_, fresh_);
  }
  tick.generation = snapshot_.generation;
  tick.alpha = image_weights(transition_, snapshot_, now_ns).alpha;
  tick.age_s = seconds_since(snapshot_.state_time_ns[0], now_ns);
  tick.image_age_s = seconds_since(snapshot_.publish_time_ns[0], now_ns);
  tick.cut = touched_->cut;
  for (const TouchedSphere& sphere : touched_->all()) tick.swept = tick.swept || sphere.swept;
  tick.force = tool_force(scene.scene(), *touched_, tool, pose);
  if (is_switch && !tick.contended) {
    gather_touched(scene.static_grid(), {still, still}, tool, before_switch_);
    const ToolForce old = tool_force(scene.scene(), before_switch_, tool, pose);
    tick.switch_jump_N = (tick.force.force_N - old.force_N).norm();
  }
  // What a contended tick did not look at is the next one's way.
  if (!tick.contended) {
    for (PlacedToolSphere& sphere : tool) sphere.before_m = sphere.position_m;
    has_way_ = true;
  }
  return tick;
}

}  // namespace stillgrid
