#include "haptic_server/rendering/answer_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "haptic_server/rendering/answer.hpp"
#include "haptic_server/rendering/stamps.hpp"

namespace stillgrid {
namespace {

/// Of a period of foresight: over which a shift is ramped out.
constexpr double kShiftPeriods = 0.5;
/// How fast the rest of a force is, but within half a period, and not faster than in 3 ms.
constexpr double kRestSlew_N_s = 200.0;
constexpr double kShortestRest_s = 3e-3;
/// How far the force may change in a tick before a contact is seen a tick late.
constexpr double kSlack_N = 0.5;
/// Far below what a hand feels, or a motor resolves.
constexpr double kTolerance_N = 1e-5;
/// Of a tool sphere's radius: an image that lies farther off than this was not foreseen at all.
constexpr double kFarthestShift = 0.5;
/// No push moves a sphere farther, whatever a segment says.
constexpr double kFarthest_m = 1.0;

/// What is left at now_ns of what is ramped out from began_ns on.
double left(std::uint64_t began_ns, double duration_s, std::uint64_t now_ns) {
  const double since_s = seconds_between(began_ns, now_ns);
  return since_s < duration_s ? 1.0 - since_s / duration_s : 0.0;
}

double shift_duration_s(const proto::SnapshotHeader& snapshot) {
  return kShiftPeriods * 1e-9 * static_cast<double>(snapshot.foresight_ns);
}

double rest_duration_s(const proto::SnapshotHeader& snapshot, const Eigen::Vector3d& rest_N) {
  const double longest_s = std::max(kShortestRest_s, shift_duration_s(snapshot));
  return std::clamp(rest_N.norm() / kRestSlew_N_s, kShortestRest_s, longest_s);
}

}  // namespace

Yielding AnswerRenderer::yielding(const Shown& shown, std::uint64_t now_ns) const noexcept {
  Yielding own;
  const double longest_m_N = shown.weights.answer_share * shown.snapshot.longest_answer_m_N;
  own.change_N = longest_m_N > 0.0 ? std::clamp(shown.change_N, -kFarthest_m / longest_m_N,
                                                kFarthest_m / longest_m_N)
                                   : shown.change_N;
  // More than this a sphere does not yield in a tick.
  const double most_N = kFarthestYield * radius_m_ / longest_m_N;
  own.slack_N =
      std::min(kSlack_N + std::abs(shown.change_N + shown.snapshot.answer_force_N), most_N);
  if (longest_m_N >= 0.0 && longest_m_N * own.slack_N <= kFarthest_m) own.longest_m_N = longest_m_N;
  own.shift_m = left(shown.began_ns, shift_duration_s(shown.snapshot), now_ns) * shown.shift_m;
  return own;
}

Eigen::Vector3d AnswerRenderer::rest_N(std::uint64_t now_ns) const noexcept {
  return left(shown_.began_ns, rest_duration_s(shown_.snapshot, shown_.rest_N), now_ns) *
         shown_.rest_N;
}

/// The force of what was displayed a tick ago, led on to the present; it stays in touched_.
ToolForce AnswerRenderer::last_image_force(const SceneView& scene,
                                           std::span<const PlacedToolSphere> tool,
                                           const ToolPose& pose, std::uint64_t now_ns) noexcept {
  touched_->drop_swept();
  const double tick_s = std::min(seconds_between(tick_ns_, now_ns), 1e-2);
  for (std::size_t i = 0; i < touched_->count; ++i)
    touched_->spheres[i].position_m += tick_s * touched_->spheres[i].velocity_m_s;
  shown_.change_N = yield_to_push(scene.scene(), tool_push(shown_.snapshot), tool, pose,
                                  shown_.change_N, kTolerance_N, *touched_);
  ToolForce force = sphere_force(scene.scene(), *touched_, tool, pose);
  const double rest =
      left(shown_.began_ns, rest_duration_s(shown_.snapshot, shown_.rest_N), now_ns);
  force.force_N += rest * shown_.rest_N;
  force.torque_N_m += rest * shown_.rest_N_m;
  return force;
}

/// The shift by which the next image shows what the tool touches where the last one showed it, on
/// average over the contacts by their depth.
void AnswerRenderer::continue_from(const GridView& grid, double push_N,
                                   std::span<const PlacedToolSphere> tool, std::uint64_t now_ns,
                                   Shown& next) const noexcept {
  next.change_N = push_N - tool_push(next.snapshot).force_N;
  next.began_ns = now_ns;
  next.shift_m.setZero();
  const Yielding by_push = yielding(next, now_ns);
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  double depth_m = 0.0;
  for (const TouchedSphere& sphere : touched_->all()) {
    if (sphere.tool_sphere >= tool.size() || sphere.number >= grid.shape.sphere_count) continue;
    const double own_m = contact_with(sphere, tool[sphere.tool_sphere]).depth_m;
    if (!(own_m > 0.0)) continue;
    const Eigen::Vector3d own_shift_m =
        sphere.position_m - displayed_m(grid, sphere.number, next.weights, by_push);
    if (!own_shift_m.allFinite()) continue;  // not in the next image
    sum_m += own_m * own_shift_m;
    depth_m += own_m;
  }
  const Eigen::Vector3d shift_m = sum_m / std::max(depth_m, 1e-12);
  // Written so that a NaN stays zero. What is cut off is in the rest of the force.
  const double farthest_m = kFarthestShift * radius_m_;
  if (const double norm_m = shift_m.norm(); norm_m > 0.0)
    next.shift_m = std::min(1.0, farthest_m / norm_m) * shift_m;
}

RenderedTick AnswerRenderer::render(const SceneView& scene, const ToolPose& pose,
                                    std::uint64_t now_ns) noexcept {
  if (epoch_ != scene.header().epoch) {
    epoch_ = scene.header().epoch;
    shown_ = {};
    touched_->clear();
    still_.clear();
    tool_.forget();
  }
  const auto tool = tool_.place(scene.scene(), pose);
  radius_m_ = 0.0;
  for (const PlacedToolSphere& sphere : tool) radius_m_ = std::max(radius_m_, sphere.radius_m);
  const bool had_image = shown_.snapshot.generation != 0;
  // Asked for only where an image comes or cannot be read.
  std::optional<ToolForce> before;
  const auto lead_on = [&] {
    if (!before) before = last_image_force(scene, tool, pose, now_ns);
  };
  std::optional<double> switch_jump_N;

  Shown next;
  const ReadResult read = read_latest(scene.buffer(), [&](const std::uint64_t* payload) {
    const proto::SnapshotHeader snapshot = load_snapshot(payload);
    const bool is_switch = had_image && snapshot.generation != shown_.snapshot.generation;
    if (is_switch) lead_on();
    next = shown_;
    next.snapshot = snapshot;
    next.weights = image_weights(Transition::kAnswer, {}, snapshot, now_ns);
    const GridView grid = scene.moving_grid(payload, snapshot);
    if (is_switch)
      continue_from(
          grid, push_ahead_N(scene.scene(), *touched_, tool, pose, tool_push(snapshot).direction),
          tool, now_ns, next);
    const Yielding now = yielding(next, now_ns);
    fresh_->clear();
    gather_touched(grid, {next.weights, is_switch ? next.weights : shown_.weights, now}, tool,
                   *fresh_);
  });
  if (read.status == ReadStatus::kEmpty && !had_image) return {};
  const bool contended = read.status != ReadStatus::kAccepted;  // empty after one: lost memory
  const bool is_new = !contended && next.snapshot.generation != shown_.snapshot.generation;
  ToolForce force;
  if (contended) {
    lead_on();
    force = *before;
    still_.drop_swept();
  } else {
    std::swap(touched_, fresh_);
    next.change_N = yield_to_push(scene.scene(), tool_push(next.snapshot), tool, pose,
                                  next.change_N, kTolerance_N, *touched_);
    force = sphere_force(scene.scene(), *touched_, tool, pose);
    if (is_new && had_image) {
      switch_jump_N = (force.force_N - before->force_N + rest_N(now_ns)).norm();
      next.rest_N = before->force_N - force.force_N;
      next.rest_N_m = before->torque_N_m - force.torque_N_m;
    }
    const double rest = left(next.began_ns, rest_duration_s(next.snapshot, next.rest_N), now_ns);
    force.force_N += rest * next.rest_N;
    force.torque_N_m += rest * next.rest_N_m;
    shown_ = next;
    still_.clear();
    gather_touched(scene.static_grid(), held_image(0), tool, still_);
    tool_.end();  // what a contended tick did not look at is the next one's way
  }
  tick_ns_ = now_ns;
  RenderedTick tick = tick_showing(shown_.snapshot, now_ns);
  tick.contended = contended;
  tick.is_new = is_new;
  tick.switch_jump_N = switch_jump_N;
  tick.alpha = 1.0 - left(shown_.began_ns, shift_duration_s(shown_.snapshot), now_ns);
  tick.stands = shown_.weights.stands;
  const Yielding yielded = yielding(shown_, now_ns);
  tick.weights = shown_.weights;
  tick.answer_N = shown_.weights.answer_share * yielded.change_N;
  tick.shift_m = yielded.shift_m;
  tick.cut = touched_->cut || still_.cut;
  for (const TouchedSpheres* touched : {touched_, &still_})
    for (const TouchedSphere& sphere : touched->all()) tick.swept = tick.swept || sphere.swept;
  tick.force = tool_force(scene.scene(), still_, tool, pose);
  tick.force.force_N += force.force_N;
  tick.force.torque_N_m += force.torque_N_m;
  tick.force.contacts += force.contacts;
  tick.force.stiffness_N_m += force.stiffness_N_m;
  return tick;
}

}  // namespace stillgrid
