#include "shared/rendering/compliant_renderer.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "shared/display/stamps.hpp"
#include "shared/rendering/touched_fields.hpp"

namespace stillgrid::rendering {
namespace {

/// Of a period of prediction: over which a shift is ramped out.
constexpr double kShiftPeriods = 0.5;
/// How fast the rest of a force is, but within half a period, and not faster than in 3 ms.
constexpr double kRestSlew_N_per_s = 200.0;
constexpr double kShortestRest_s = 3e-3;
/// Of a tool sphere's radius: a snapshot that lies farther off than this was not predicted at all.
constexpr double kFarthestShift = 0.5;

/// What is left at now_ns of what is ramped out from began_ns on.
double left(std::uint64_t began_ns, double duration_s, std::uint64_t now_ns) {
  const double since_s = display::seconds_between(began_ns, now_ns);
  return since_s < duration_s ? 1.0 - since_s / duration_s : 0.0;
}

double shift_duration_s(const proto::SnapshotHeader& snapshot) {
  return kShiftPeriods * 1e-9 * static_cast<double>(snapshot.prediction_ns);
}

double rest_duration_s(const proto::SnapshotHeader& snapshot, const Eigen::Vector3d& change_N) {
  const double longest_s = std::max(kShortestRest_s, shift_duration_s(snapshot));
  return std::clamp(change_N.norm() / kRestSlew_N_per_s, kShortestRest_s, longest_s);
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

CompliantDisplay CompliantRenderer::compliant_display(const Display& display,
                                                      std::uint64_t now_ns) const noexcept {
  return {.motion = display.response.motion,
          .slack_m = display.response.count > 0 ? kMaxCompliantShift * radius_m_ : 0.0,
          .share = left(display.began_ns, display.shift_s, now_ns),
          .shifts = display.shifts};
}

/// The force of the moving spheres in touched_, which have given way to it then.
ToolForce CompliantRenderer::solve(const TickScene& scene, bool is_switch,
                                   Display& display) noexcept {
  unsolved_N_ = solver_.solve(scene.fixed(), tool_, scene.pose, radius_m_, is_switch, *touched_,
                              display.response);
  return sphere_force(scene.fixed(), *touched_, tool_, scene.pose);
}

/// With what is left of how a switch made it begin: by a share of it, and a residual force. Where
/// the snapshot presses more than was displayed, all that it presses comes evenly; by a residual
/// alone that would pull once contact is lost.
ToolForce CompliantRenderer::with_rest(ToolForce force, const Display& display,
                                       std::uint64_t now_ns) noexcept {
  const double rest = left(display.began_ns, display.rest_s, now_ns);
  const double share = 1.0 + rest * (display.force_share - 1.0);
  force.force_N = share * force.force_N + rest * display.residual_N;
  force.torque_N_m = share * force.torque_N_m + rest * display.residual_torque_N_m;
  return force;
}

/// Begins to display a snapshot, whose force is that, as the force displayed was.
void CompliantRenderer::begin_as(const ToolForce& displayed, const ToolForce& force,
                                 Display& display) const noexcept {
  const double size_N2 = force.force_N.squaredNorm();
  display.force_share =
      size_N2 > 0.0 ? std::clamp(displayed.force_N.dot(force.force_N) / size_N2, 0.0, 1.0) : 1.0;
  display.residual_N = displayed.force_N - display.force_share * force.force_N;
  display.residual_torque_N_m = displayed.torque_N_m - display.force_share * force.torque_N_m;
  display.rest_s = rest_duration_s(reader().snapshot(), displayed.force_N - force.force_N);
}

/// Leads what was displayed a tick ago on to the present; it stays in touched_.
void CompliantRenderer::lead_on(const TickScene& scene) noexcept {
  if (led_on_) return;
  touched_->drop_swept();
  const double tick_s = std::min(display::seconds_between(tick_ns_, scene.now_ns), 1e-2);
  // What was ramped out since then; where each tick brings a snapshot nothing else does that.
  const double back = left(shown_.began_ns, shown_.shift_s, tick_ns_) -
                      left(shown_.began_ns, shown_.shift_s, scene.now_ns);
  const display::SnapshotWeights weights =
      display::snapshot_weights(transition_, {}, reader().snapshot(), scene.now_ns);
  const double led_s = weights.prediction_s - shown_.weights.prediction_s;
  for (std::size_t i = 0; i < touched_->count; ++i) {
    TouchedSphere& sphere = touched_->spheres[i];
    const Eigen::Vector3d way_m = (weights.step_share > 0.0 ? led_s : tick_s) * sphere.led_m_s -
                                  back * shown_.shifts.of(sphere.body);
    for (Eigen::Vector3d* at_m : {&sphere.position_m, &sphere.base_m, &sphere.seen_m})
      *at_m += way_m;
  }
  shown_.response.take(reader().snapshot(), weights);
  give_way(shown_.response.motion, *touched_);
  shown_.weights = weights;
  const ToolForce bare = solve(scene, false, shown_);
  led_bare_N_ = bare.force_N;
  led_on_ = with_rest(bare, shown_, scene.now_ns);
}

/// The response that the next snapshot has of a touched sphere.
std::optional<display::ResponseMatrix> CompliantRenderer::next_response(
    const TickScene& scene, const collision::GridView& moving,
    const TouchedSphere& sphere) const noexcept {
  const display::ModeMotion& motion = next_.response.motion;
  if (const TouchedField* field = touched_->field_of(sphere))
    return response_in(scene.view.fields(), moving, *field, next_.weights, {.motion = motion});
  if (sphere.number >= moving.shape.sphere_count) return std::nullopt;
  return display::response_of(moving, collision::load_line(moving, sphere.number),
                              motion.largest_response);
}

/// Where the next snapshot displays it; nowhere if it is not there.
std::optional<Eigen::Vector3d> CompliantRenderer::next_place_m(
    const TickScene& scene, const collision::GridView& moving, const TouchedSphere& sphere,
    const CompliantDisplay& by_push) const noexcept {
  if (const TouchedField* field = touched_->field_of(sphere))
    return displayed_m(scene.view.fields(), moving, *field, next_.weights, by_push);
  if (sphere.number >= moving.shape.sphere_count) return std::nullopt;
  const Eigen::Vector3d now_m = displayed_m(moving, sphere.number, next_.weights, by_push);
  return now_m.allFinite() ? std::optional(now_m) : std::nullopt;
}

/// Displays the next snapshot under the forces that are displayed, its bodies where they are.
void CompliantRenderer::continue_from(const TickScene& scene,
                                      const collision::GridView& moving) noexcept {
  display::ModeDisplacements push = display::ModeDisplacements::Zero();
  for (std::size_t i = 0; i < touched_->count; ++i) {
    const TouchedSphere& sphere = touched_->spheres[i];
    const auto response = next_response(scene, moving, sphere);
    if (response)
      push += response->cast<double>().transpose() *
              -sphere_force_of(scene.fixed(), sphere, tool_, scene.pose).force_N;
  }
  next_.response.follow(push);
  next_.began_ns = scene.now_ns;
  next_.shifts = {};
  shift_bodies(scene, moving);
}

/// Adds how the force on the tool differs for a sphere that the next snapshot shows elsewhere.
void CompliantRenderer::compare(const TickScene& scene, TouchedSphere sphere,
                                const Eigen::Vector3d& led_m,
                                const Eigen::Vector3d& now_m) noexcept {
  sphere.position_m = sphere.seen_m = now_m;
  error_N_ += sphere_force_of(scene.fixed(), sphere, tool_, scene.pose).force_N;
  sphere.position_m = sphere.seen_m = led_m;
  error_N_ -= sphere_force_of(scene.fixed(), sphere, tool_, scene.pose).force_N;
}

/// Shifts each body that the tool touches so that it is displayed where the last snapshot showed
/// it, on average over its contacts by their depth.
void CompliantRenderer::shift_bodies(const TickScene& scene,
                                     const collision::GridView& moving) noexcept {
  const CompliantDisplay by_push = compliant_display(next_, scene.now_ns);
  std::array<double, proto::kMaxShiftedBodies> depth_m{};
  const double share = left(shown_.began_ns, shown_.shift_s, scene.now_ns);
  BodyShifts& shifts = next_.shifts;
  error_N_.setZero();
  for (const TouchedSphere& sphere : touched_->all()) {
    if (sphere.tool_sphere >= tool_.size()) continue;
    const auto now_m = next_place_m(scene, moving, sphere, by_push);
    if (!now_m) continue;
    compare(scene, sphere, sphere.position_m - share * shown_.shifts.of(sphere.body), *now_m);
    const double own_m = contact_with(sphere, tool_[sphere.tool_sphere]).depth_m;
    if (!(own_m > 0.0)) continue;
    const Eigen::Vector3d own_shift_m = sphere.position_m - *now_m;
    std::size_t at = 0;
    while (at < shifts.count && shifts.shifts[at].body != sphere.body) ++at;
    if (at == proto::kMaxShiftedBodies) continue;
    if (at == shifts.count) shifts.shifts[shifts.count++] = {sphere.body, Eigen::Vector3d::Zero()};
    shifts.shifts[at].shift_m += own_m * own_shift_m;
    depth_m[at] += own_m;
  }
  // What is cut off is in the rest of the force.
  const double farthest_m = kFarthestShift * radius_m_;
  double error_m = 0.0;
  for (std::size_t at = 0; at < shifts.count; ++at) {
    Eigen::Vector3d& shift_m = shifts.shifts[at].shift_m;
    shift_m /= depth_m[at];
    error_m =
        std::max(error_m, (shift_m - share * shown_.shifts.of(shifts.shifts[at].body)).norm());
    const double norm_m = shift_m.norm();
    if (norm_m > farthest_m) shift_m *= farthest_m / norm_m;
  }
  if (shifts.count > 0) error_ = {error_m, error_N_.norm()};
}

void CompliantRenderer::gather(const TickScene& scene, const proto::SnapshotHeader& latest,
                               const collision::GridView& moving) noexcept {
  const bool is_switch =
      reader().has_snapshot() && latest.snapshot_id != reader().snapshot().snapshot_id;
  if (is_switch) lead_on(scene);
  error_.reset();
  next_ = shown_;
  next_.weights = display::snapshot_weights(transition_, {}, latest, scene.now_ns);
  next_.shift_s = shift_duration_s(latest);
  next_.response.take(latest, next_.weights);
  if (is_switch) continue_from(scene, moving);
  fresh_->clear();
  scene.gather_moving(moving,
                      {next_.weights, is_switch ? next_.weights : shown_.weights,
                       compliant_display(next_, scene.now_ns)},
                      tool_, *fresh_);
}

void CompliantRenderer::show(const TickScene& scene, const publication::SnapshotLook& look,
                             RenderedTick& tick) noexcept {
  const std::uint64_t now_ns = scene.now_ns;
  ToolForce force;
  if (look.accepted()) {
    std::swap(touched_, fresh_);
    force = solve(scene, look.is_new, next_);
    if (look.is_new && !look.is_first) {
      tick.prediction_error = error_;
      tick.switch_jump_N = (force.force_N - led_bare_N_).norm();
      begin_as(*led_on_, force, next_);
    }
    force = with_rest(force, next_, now_ns);
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
  tick.weights = shown_.weights;
  const double shift = left(shown_.began_ns, shown_.shift_s, now_ns);
  tick.weights.alpha = 1.0 - shift;
  tick.modes = shown_.response.motion.displacements;
  tick.shifts = shown_.shifts;
  for (BodyShifts::Shift& body : tick.shifts.shifts) body.shift_m *= shift;
  tick.unsolved_N = unsolved_N_;
  tick.truncated = touched_->truncated || static_.truncated;
  tick.swept = touched_->has_swept() || static_.has_swept();
  tick.force = scene.force_of(static_, tool_);
  add(tick.force, force);
}

}  // namespace stillgrid::rendering
