#include "haptic_server/rendering/still_image.hpp"

#include <utility>

namespace stillgrid {
namespace {

double seconds_since(std::uint64_t then_ns, std::uint64_t now_ns) {
  return now_ns > then_ns ? static_cast<double>(now_ns - then_ns) * 1e-9 : 0.0;
}

}  // namespace

std::span<const PlacedToolSphere> StillImageRenderer::place(const proto::SceneHeader& scene,
                                                            const ToolPose& tool) {
  for (std::uint32_t i = 0; i < scene.tool_sphere_count; ++i) {
    const auto& p = scene.tool[i].position_m;
    tool_[i] = {tool.position_m + tool.orientation * Eigen::Vector3d(p[0], p[1], p[2]),
                static_cast<double>(scene.tool[i].radius_m)};
  }
  return {tool_.data(), scene.tool_sphere_count};
}

RenderedTick StillImageRenderer::render(const SceneView& scene, const ToolPose& pose,
                                        std::uint64_t now_ns) noexcept {
  const auto tool = place(scene.scene(), pose);
  if (epoch_ != scene.header().epoch) {
    epoch_ = scene.header().epoch;
    snapshot_ = {};
    touched_->clear();
  }

  proto::SnapshotHeader snapshot{};
  ImageWeights weights;
  bool is_switch = false;
  const ReadResult read = read_latest(scene.buffer(), [&](const std::uint64_t* payload) {
    snapshot = load_struct<proto::SnapshotHeader>(payload);
    weights = image_weights(transition_, snapshot, now_ns);
    const GridView grid = scene.moving_grid(payload, snapshot);
    fresh_->clear();
    gather_touched(grid, weights, tool, *fresh_);
    is_switch = snapshot_.generation != 0 && snapshot.generation == snapshot_.generation + 1;
    before_switch_.clear();
    if (is_switch)
      gather_touched(grid, weights_before_switch(transition_, snapshot, now_ns), tool,
                     before_switch_);
  });

  RenderedTick tick;
  const bool had_image = snapshot_.generation != 0;
  if (read.status == ReadStatus::kEmpty && !had_image) return tick;
  tick.contended = read.status != ReadStatus::kAccepted;  // empty after an image: lost memory
  if (!tick.contended) {
    tick.is_new = snapshot.generation != snapshot_.generation;
    snapshot_ = snapshot;
    gather_touched(scene.static_grid(), image_weights(Transition::kHold, snapshot_, now_ns), tool,
                   *fresh_);
    std::swap(touched_, fresh_);
  }
  tick.generation = snapshot_.generation;
  tick.alpha = image_weights(transition_, snapshot_, now_ns).alpha;
  tick.age_s = seconds_since(snapshot_.state_time_ns[0], now_ns);
  tick.image_age_s = seconds_since(snapshot_.publish_time_ns[0], now_ns);
  tick.cut = touched_->cut;
  tick.force = tool_force(scene.scene(), *touched_, tool, pose.velocity_m_s);
  if (is_switch && !tick.contended) {
    gather_touched(scene.static_grid(), image_weights(Transition::kHold, snapshot_, now_ns), tool,
                   before_switch_);
    const ToolForce old = tool_force(scene.scene(), before_switch_, tool, pose.velocity_m_s);
    tick.switch_jump_N = (tick.force.force_N - old.force_N).norm();
  }
  return tick;
}

}  // namespace stillgrid
