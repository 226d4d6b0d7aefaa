#include "shared/rendering/compliant_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "shared/display/stamps.hpp"
#include "shared/rendering/compliant_prediction.hpp"

namespace stillgrid::rendering {
namespace {

/// Of a period of prediction: over which a shift is ramped out.
constexpr double kShiftPeriods = 0.5;
/// How fast the rest of a force is, but within half a period, and not faster than in 3 ms.
constexpr double kRestSlew_N_per_s = 200.0;
constexpr double kShortestRest_s = 3e-3;
/// How far the force may change in a tick before a contact is seen a tick late.
constexpr double kSlack_N = 0.5;
/// Far below what a hand feels, or a motor resolves.
constexpr double kTolerance_N = 1e-5;
/// Of a tool sphere's radius: a snapshot that lies farther off than this was not predicted at all.
constexpr double kFarthestShift = 0.5;
/// No push moves a sphere farther, whatever a segment says.
constexpr double kFarthest_m = 1.0;

/// What is left at now_ns of what is ramped out from began_ns on.
double left(std::uint64_t began_ns, double duration_s, std::uint64_t now_ns) {
  const double since_s = display::seconds_between(began_ns, now_ns);
  return since_s < duration_s ? 1.0 - since_s / duration_s : 0.0;
}

double shift_duration_s(const proto::SnapshotHeader& snapshot) {
  return kShiftPeriods * 1e-9 * static_cast<double>(snapshot.prediction_ns);
}

double rest_duration_s(const proto::SnapshotHeader& snapshot, const Eigen::Vector3d& residual_N) {
  const double longest_s = std::max(kShortestRest_s, shift_duration_s(snapshot));
  return std::clamp(residual_N.norm() / kRestSlew_N_per_s, kShortestRest_s, longest_s);
}

void add(ToolForce& sum, const ToolForce& force) {
  sum.force_N += force.force_N;
  sum.torque_N_m += force.torque_N_m;
  sum.contacts += force.contacts;
  sum.stiffness_N_per_m += force.stiffness_N_per_m;
}

}  // namespace

void CompliantRenderer::prepare(const TickScene& scene, bool is_other) noexcept {
  if (is_other) {
    shown_ = {};
    touched_->clear();
    static_.clear();
    sweep_.forget();
  }
  tool_ = sweep_.place(scene.fixed(), scene.pose);
  radius_m_ = 0.0;
  for (const PlacedToolSphere& sphere : tool_) radius_m_ = std::max(radius_m_, sphere.radius_m);
  led_on_.reset();
}

CompliantDisplay CompliantRenderer::compliant_display(const proto::SnapshotHeader& snapshot,
                                                      const Display& display,
                                                      std::uint64_t now_ns) const noexcept {
  CompliantDisplay own;
  const double max_m_per_N = display.weights.compliance_share * snapshot.max_compliance_m_per_N;
  own.change_N = max_m_per_N > 0.0 ? std::clamp(display.change_N, -kFarthest_m / max_m_per_N,
                                                kFarthest_m / max_m_per_N)
                                   : display.change_N;
  // More than this a sphere does not give way in a tick.
  const double most_N = kMaxCompliantShift * radius_m_ / max_m_per_N;
  own.slack_N =
      std::min(kSlack_N + std::abs(display.change_N + snapshot.compliance_force_N), most_N);
  if (max_m_per_N >= 0.0 && max_m_per_N * own.slack_N <= kFarthest_m) own.max_m_per_N = max_m_per_N;
  own.shift_m = left(display.began_ns, display.shift_s, now_ns) * display.shift_m;
  return own;
}

/// The force of the moving spheres in touched_, which have given way to it then. Pre: they are of
/// the last accepted snapshot.
ToolForce CompliantRenderer::solve(const TickScene& scene, Display& display) noexcept {
  display.change_N = solve_compliance(scene.fixed(), tool_push(reader().snapshot()), tool_,
                                      scene.pose, display.change_N, kTolerance_N, *touched_);
  return sphere_force(scene.fixed(), *touched_, tool_, scene.pose);
}

/// Leads what was displayed a tick ago on to the present; it stays in touched_.
void CompliantRenderer::lead_on(const TickScene& scene) noexcept {
  if (led_on_) return;
  touched_->drop_swept();
  const double tick_s = std::min(display::seconds_between(tick_ns_, scene.now_ns), 1e-2);
  // What was ramped out since then; where each tick brings a snapshot nothing else does that.
  const Eigen::Vector3d back_m = (left(shown_.began_ns, shown_.shift_s, tick_ns_) -
                                  left(shown_.began_ns, shown_.shift_s, scene.now_ns)) *
                                 shown_.shift_m;
  for (std::size_t i = 0; i < touched_->count; ++i)
    touched_->spheres[i].position_m += tick_s * touched_->spheres[i].velocity_m_s - back_m;
  ToolForce force = solve(scene, shown_);
  const double rest = left(shown_.began_ns, shown_.rest_s, scene.now_ns);
  force.force_N += rest * shown_.residual_N;
  force.torque_N_m += rest * shown_.residual_torque_N_m;
  led_on_ = force;
}

/// Shifts the next display so that it shows what the tool touches where the last one showed it, on
/// average over the contacts by their depth.
void CompliantRenderer::continue_from(const TickScene& scene, const proto::SnapshotHeader& latest,
                                      const collision::GridView& moving) noexcept {
  const ToolPush push = tool_push(latest);
  next_.change_N =
      push_ahead_N(scene.fixed(), *touched_, tool_, scene.pose, push.direction) - push.force_N;
  next_.began_ns = scene.now_ns;
  next_.shift_m.setZero();
  const CompliantDisplay by_push = compliant_display(latest, next_, scene.now_ns);
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  double depth_m = 0.0;
  for (const TouchedSphere& sphere : touched_->all()) {
    if (sphere.tool_sphere >= tool_.size() || sphere.number >= moving.shape.sphere_count) continue;
    const double own_m = contact_with(sphere, tool_[sphere.tool_sphere]).depth_m;
    if (!(own_m > 0.0)) continue;
    const Eigen::Vector3d own_shift_m =
        sphere.position_m - displayed_m(moving, sphere.number, next_.weights, by_push);
    if (!own_shift_m.allFinite()) continue;  // not in the next snapshot
    sum_m += own_m * own_shift_m;
    depth_m += own_m;
  }
  const Eigen::Vector3d shift_m = sum_m / std::max(depth_m, 1e-12);
  // Written so that a NaN stays zero. What is cut off is in the rest of the force.
  const double farthest_m = kFarthestShift * radius_m_;
  if (const double norm_m = shift_m.norm(); norm_m > 0.0)
    next_.shift_m = std::min(1.0, farthest_m / norm_m) * shift_m;
}

void CompliantRenderer::gather(const TickScene& scene, const proto::SnapshotHeader& latest,
                               const collision::GridView& moving) noexcept {
  const bool is_switch =
      reader().has_snapshot() && latest.snapshot_id != reader().snapshot().snapshot_id;
  if (is_switch) lead_on(scene);
  next_ = shown_;
  next_.weights = display::snapshot_weights(transition_, {}, latest, scene.now_ns);
  next_.shift_s = shift_duration_s(latest);
  if (is_switch) continue_from(scene, latest, moving);
  fresh_->clear();
  gather_touched(moving,
                 {next_.weights, is_switch ? next_.weights : shown_.weights,
                  compliant_display(latest, next_, scene.now_ns)},
                 tool_, *fresh_);
}

void CompliantRenderer::show(const TickScene& scene, const publication::SnapshotLook& look,
                             RenderedTick& tick) noexcept {
  const std::uint64_t now_ns = scene.now_ns;
  ToolForce force;
  if (look.accepted()) {
    std::swap(touched_, fresh_);
    force = solve(scene, next_);
    if (look.is_new && !look.is_first) {
      const double rest = left(shown_.began_ns, shown_.rest_s, now_ns);
      tick.switch_jump_N = (force.force_N - led_on_->force_N + rest * shown_.residual_N).norm();
      next_.residual_N = led_on_->force_N - force.force_N;
      next_.residual_torque_N_m = led_on_->torque_N_m - force.torque_N_m;
      next_.rest_s = rest_duration_s(reader().snapshot(), next_.residual_N);
    }
    const double rest = left(next_.began_ns, next_.rest_s, now_ns);
    force.force_N += rest * next_.residual_N;
    force.torque_N_m += rest * next_.residual_torque_N_m;
    shown_ = next_;
    static_.clear();
    scene.gather_static(tool_, static_);
    sweep_.end();  // what a contended tick did not look at the next one sweeps
  } else {
    lead_on(scene);
    force = *led_on_;
    static_.drop_swept();
  }
  tick_ns_ = now_ns;
  const CompliantDisplay yielded = compliant_display(reader().snapshot(), shown_, now_ns);
  tick.weights = shown_.weights;
  tick.weights.alpha = 1.0 - left(shown_.began_ns, shown_.shift_s, now_ns);
  tick.force_change_N = shown_.weights.compliance_share * yielded.change_N;
  tick.shift_m = yielded.shift_m;
  tick.truncated = touched_->truncated || static_.truncated;
  tick.swept = touched_->has_swept() || static_.has_swept();
  tick.force = scene.force_of(static_, tool_);
  add(tick.force, force);
}

}  // namespace stillgrid::rendering
