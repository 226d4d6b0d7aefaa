#include "shared/dynamics/engine.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "shared/dynamics/rigid_motion.hpp"
#include "shared/realtime/flush_denormals.hpp"

namespace stillgrid::dynamics {
namespace {

// Iterations of a substep, in turn forwards and backwards. A body with many contacts at once, as a
// block that lands flat, is turned aside by fewer.
constexpr int kIterations = 5, kIterationsOfBalls = 2;

std::size_t at(std::int32_t index) {
  return static_cast<std::size_t>(index);
}

Description validated(Description description) {
  validate(description);
  return description;
}

void set_vector(float (&to)[3], const Vector4& v) {
  to[0] = static_cast<float>(v.x);
  to[1] = static_cast<float>(v.y);
  to[2] = static_cast<float>(v.z);
}
/// How much `now` is more than the float that `before` was rounded to.
Vector4 change_since(const Vector4& before, const float (&now)[3]) {
  return {now[0] - static_cast<float>(before.x), now[1] - static_cast<float>(before.y),
          now[2] - static_cast<float>(before.z)};
}

}  // namespace

Engine::Engine(Description description, SceneState state)
    : description_(validated(std::move(description))),
      fingerprint_(fingerprint(description_)),
      state_(std::move(state)),
      springs_(description_),
      listing_(description_),
      forces_N_(description_.nodes.size()),
      poses_of_others_(description_.rigid_bodies.size()),
      wrenches_(description_.joints.empty() ? 0 : description_.rigid_bodies.size()),
      driven_of_rigid_(description_.rigid_bodies.size(), -1),
      bound_(spectrum_bound(description_)) {
  for (std::size_t r = 0; r < description_.rigid_bodies.size(); ++r) {
    if (!description_.rigid_bodies[r].is_driven) continue;
    driven_of_rigid_[r] = static_cast<std::int32_t>(driven_.size());
    driven_.push_back(r);
  }
  reactions_.resize(driven_.size());
  poses_.resize(driven_.size());
  if (state_.is_here.empty()) state_.is_here.assign(description_.rigid_bodies.size(), 1);
  const std::size_t movers = description_.nodes.size() + description_.rigid_bodies.size() + 1;
  bodies_.movers.resize(movers);
  bodies_.changes.resize(movers);
  bodies_.changed.reserve(movers);
  bodies_.inverse_inertias.resize(movers);
  bodies_.places.resize(description_.spheres.size());
  bodies_.arms.resize(description_.spheres.size());
}

void Engine::aim_driven(std::span<const DrivenPose> driven, double tick_s) {
  assert(driven.size() == driven_.size());
  for (std::size_t k = 0; k < driven_.size(); ++k) {
    const std::size_t r = driven_[k];
    poses_[k] = driven[k];
    reactions_[k] = {};
    const std::uint8_t is_here = driven[k].is_here ? 1 : 0;
    is_stale_ = is_stale_ || is_here != state_.is_here[r];
    if (is_here > state_.is_here[r]) {
      state_.rigid_position_m[r] = Vector4(driven[k].position_m - tick_s * driven[k].velocity_m_s);
      state_.orientation[r] = Vector4(driven[k].orientation);
    }
    state_.is_here[r] = is_here;
    const Vector4 way = Vector4(driven[k].position_m) - state_.rigid_position_m[r];
    state_.rigid_velocity_m_s[r] = (is_here != 0 ? 1.0 / tick_s : 0.0) * way;
    const Eigen::Vector3d turn =
        rotation_vector(driven[k].orientation * state_.orientation[r].quaternion().conjugate());
    state_.angular_velocity_rad_s[r] = (is_here != 0 ? 1.0 / tick_s : 0.0) * Vector4(turn);
  }
}

void Engine::drift(double h) {
  for (std::size_t i = 0; i < state_.node_position_m.size(); ++i)
    state_.node_position_m[i] = state_.node_position_m[i] + h * state_.node_velocity_m_s[i];
  for (const std::int32_t rigid : others()) {
    const std::size_t r = at(rigid);
    state_.rigid_position_m[r] = state_.rigid_position_m[r] + h * state_.rigid_velocity_m_s[r];
    Eigen::Quaterniond orientation = state_.orientation[r].quaternion();
    Eigen::Vector3d spin = state_.angular_velocity_rad_s[r].vector();
    const Description::Rigid& body = description_.rigid_bodies[r];
    if (body.is_driven)
      orientation = turned(orientation, spin, h);
    else
      turn_freely(orientation, spin, body.inertia_kg_m2, h);
    state_.orientation[r] = Vector4(orientation);
    state_.angular_velocity_rad_s[r] = Vector4(spin);
  }
}

void Engine::load_movers() {
  for (std::size_t i = 0; i < state_.node_position_m.size(); ++i)
    set_vector(bodies_.movers[i].velocity_m_s, state_.node_velocity_m_s[i]);
  for (const std::int32_t rigid : others()) {
    const std::size_t r = at(rigid), m = at(listing_.mover_of_rigid()[r]);
    set_vector(bodies_.movers[m].velocity_m_s, state_.rigid_velocity_m_s[r]);
    set_vector(bodies_.movers[m].spin, state_.angular_velocity_rad_s[r]);
    const Description::Rigid& body = description_.rigid_bodies[r];
    if (body.is_driven) continue;
    const Eigen::Matrix3f inverse =
        inverse_inertia(state_.orientation[r].quaternion(), body.inertia_kg_m2).cast<float>();
    bodies_.inverse_inertias[m] = {inverse(0, 0), inverse(0, 1), inverse(0, 2), 0.0F,
                                   inverse(1, 1), inverse(1, 2), inverse(2, 2), 0.0F};
  }
}

void Engine::place_spheres(double h) {
  const double falls = h * h * description_.gravity_m_s2.norm();
  for (const std::int32_t rigid : others()) {
    const std::size_t r = at(rigid);
    poses_of_others_[r] = {state_.orientation[r].quaternion().toRotationMatrix(),
                           state_.rigid_velocity_m_s[r].vector().norm(),
                           state_.angular_velocity_rad_s[r].vector().norm()};
  }
  for (const OtherSphere& sphere : other_spheres_) {
    SpherePlace& place = bodies_.places[at(sphere.place)];
    Vector4 moved = -1.0 * sphere.base;
    double speed = 0.0;
    if (sphere.rigid >= 0) {
      const PoseOfOther& pose = poses_of_others_[at(sphere.rigid)];
      const Vector4 arm(pose.axes * sphere.local_m);
      moved = moved + state_.rigid_position_m[at(sphere.rigid)] + arm;
      speed = pose.speed_m_s + pose.spin_rad_s * sphere.arm_m;
      set_vector(bodies_.arms[at(sphere.place)].arm_m, arm);
    } else {
      double square = 0.0;
      for (std::size_t n = 0; n < at(sphere.node_count); ++n) {
        const std::size_t node = at(sphere.nodes[n]);
        moved = moved + sphere.weights[n] * state_.node_position_m[node];
        square = std::max(square, state_.node_velocity_m_s[node].vector().squaredNorm());
      }
      speed = std::sqrt(square);
    }
    set_vector(place.moved_m, moved);
    place.margin_m = static_cast<float>(h * speed + falls);
  }
}

/// Whether no sphere leaves its reach within the tick.
bool Engine::listing_holds(double tick_s) {
  const double falls = tick_s * tick_s * description_.gravity_m_s2.norm();
  if (is_stale_ || !stay_within(balls_, state_, tick_s, falls)) return false;
  place_spheres(tick_s);
  bool holds = true;
  for (const OtherSphere& sphere : other_spheres_) {
    const SpherePlace& place = bodies_.places[at(sphere.place)];
    const float x = place.moved_m[0], y = place.moved_m[1], z = place.moved_m[2];
    const double way = std::sqrt(x * x + y * y + z * z) + place.margin_m;
    holds = holds && way < sphere.base.w;
  }
  return holds;
}

/// Sets what stays as it is from listing to listing.
void Engine::adopt_listing() {
  const std::size_t nodes = forces_N_.size();
  balls_.first_mover = nodes;
  balls_.rigid.clear();
  balls_.place.clear();
  balls_.radius_m.clear();
  balls_.base.clear();
  other_spheres_.clear();
  for (std::size_t k = 0; k < listing_.order().size(); ++k) {
    const std::size_t s = at(listing_.order()[k]);
    if (listing_.kinds()[s] != SideKind::kBall) {
      const Description::Sphere& sphere = description_.spheres[s];
      other_spheres_.push_back({static_cast<std::int32_t>(k), sphere.rigid, sphere.node_count,
                                sphere.nodes, sphere.weights, sphere.local_m, sphere.local_m.norm(),
                                listing_.base()[k]});
      bodies_.arms[k].radius_m = static_cast<float>(sphere.radius_m);
      continue;
    }
    balls_.rigid.push_back(description_.spheres[s].rigid);
    balls_.place.push_back(static_cast<std::int32_t>(k));
    balls_.radius_m.push_back(static_cast<float>(description_.spheres[s].radius_m));
    balls_.base.push_back(listing_.base()[k]);
  }
  for (std::size_t i = 0; i < nodes; ++i) {
    const Description::Node& node = description_.nodes[i];
    bodies_.movers[i].inverse_mass_per_kg =
        node.is_pinned ? 0.0F : static_cast<float>(1.0 / node.mass_kg);
  }
  for (std::size_t k = 0; k < listing_.rigid_order().size(); ++k) {
    const Description::Rigid& body = description_.rigid_bodies[at(listing_.rigid_order()[k])];
    bodies_.movers[nodes + k].inverse_mass_per_kg =
        body.is_driven ? 0.0F : static_cast<float>(1.0 / body.mass_kg);
    bodies_.inverse_inertias[nodes + k] = {};
  }
}

/// At the velocities of the state.
void Engine::sum_forces() {
  std::fill(forces_N_.begin(), forces_N_.end(), Vector4());
  springs_.add_forces(state_.node_position_m, state_.node_velocity_m_s, forces_N_);
  std::fill(wrenches_.begin(), wrenches_.end(), Wrench());
  add_joint_forces(description_, state_, forces_N_, wrenches_);
}

void Engine::apply_forces(double h) {
  for (std::size_t i = 0; i < forces_N_.size(); ++i) {
    if (description_.nodes[i].is_pinned) continue;
    Vector4& velocity = state_.node_velocity_m_s[i];
    velocity = velocity + (h / description_.nodes[i].mass_kg) * forces_N_[i];
  }
  if (wrenches_.empty()) return;
  for (const std::int32_t rigid : others()) {
    const std::size_t r = at(rigid);
    const Description::Rigid& body = description_.rigid_bodies[r];
    if (body.is_driven) continue;
    Vector4 &velocity = state_.rigid_velocity_m_s[r], &spin = state_.angular_velocity_rad_s[r];
    velocity = velocity + h / body.mass_kg * Vector4(wrenches_[r].force_N);
    spin =
        spin + h * Vector4(inverse_inertia(state_.orientation[r].quaternion(), body.inertia_kg_m2) *
                           wrenches_[r].torque_N_m);
  }
}

/// Dampers act at the velocities of the start: at those that forces alone make of the middle, a
/// body at rest between springs and contacts would be damped.
void Engine::kick(double h, const Vector4& falls) {
  sum_forces();
  apply_forces(h);
  for (std::size_t i = 0; i < forces_N_.size(); ++i) {
    Vector4& velocity = state_.node_velocity_m_s[i];
    if (!description_.nodes[i].is_pinned) velocity = velocity + falls;
    set_vector(bodies_.movers[i].velocity_m_s, velocity);
  }
  for (const std::int32_t rigid : others()) {
    const std::size_t r = at(rigid), m = at(listing_.mover_of_rigid()[r]);
    if (driven_of_rigid_[r] >= 0) continue;
    Vector4& velocity = state_.rigid_velocity_m_s[r];
    velocity = velocity + falls;
    set_vector(bodies_.movers[m].velocity_m_s, velocity);
    set_vector(bodies_.movers[m].spin, state_.angular_velocity_rad_s[r]);
  }
}

/// Floats carry only the changes of a substep, so that velocities keep all their digits.
void Engine::apply_impulses() {
  for (std::size_t i = 0; i < forces_N_.size(); ++i) {
    Vector4& velocity = state_.node_velocity_m_s[i];
    velocity = velocity + change_since(velocity, bodies_.movers[i].velocity_m_s);
  }
  for (const std::int32_t rigid : others()) {
    const std::size_t r = at(rigid);
    if (driven_of_rigid_[r] >= 0) continue;
    const Mover& mover = bodies_.movers[at(listing_.mover_of_rigid()[r])];
    Vector4 &velocity = state_.rigid_velocity_m_s[r], &spin = state_.angular_velocity_rad_s[r];
    velocity = velocity + change_since(velocity, mover.velocity_m_s);
    spin = spin + change_since(spin, mover.spin);
  }
}

/// Position Verlet is stable where (h w)^2 / 4 + h d / 2 < 1 for the fastest vibration w and the
/// strongest damper d, and errs by (h w)^2 / 24 of the phase.
int Engine::substeps(double tick_s) const {
  constexpr double kMaxStable = 0.9, kMaxTurn_rad = 1.0;
  for (int count = 1;; ++count) {
    const double h = tick_s / count, turn = h * bound_.frequency_rad_s;
    const double share = 0.25 * turn * turn + 0.5 * h * bound_.damping_per_s;
    if (share <= kMaxStable && turn <= kMaxTurn_rad) return count;
  }
}

void Engine::substep(double h) {
  RowList& rows = listing_.rows();
  const auto step = static_cast<float>(h);
  const Vector4 falls = h * Vector4(description_.gravity_m_s2);
  drift(0.5 * h);
  load_movers();
  place_spheres(h);
  start_balls(balls_, state_, bodies_, h, h * h * description_.gravity_m_s2.norm());
  prepare_rows(rows, bodies_, step, live_);
  kick(h, falls);
  kick_balls(balls_, state_, bodies_, falls);
  warm_start_rows(rows, bodies_, live_);
  for (int k = 0; k < kIterations; ++k)
    solve_rows(rows, bodies_, live_, k % 2 == 1, k < kIterationsOfBalls);
  finish_rows(rows, step, live_);
  finish_balls(balls_, state_, bodies_, h, falls);
  apply_impulses();
  if (!driven_.empty()) note_reactions();
  drift(0.5 * h);
}

void Engine::step(std::span<const DrivenPose> driven, double tick_s) {
  const realtime::FlushDenormals flush;  // or results would depend on the mode of the thread
  aim_driven(driven, tick_s);
  if (!listing_holds(tick_s)) {
    listing_.list(state_, tick_s);
    adopt_listing();
    is_stale_ = false;
  }
  const int count = substeps(tick_s);
  for (int k = 0; k < count; ++k) substep(tick_s / count);
  turn_balls(balls_, state_, tick_s);
  for (std::size_t k = 0; k < driven_.size(); ++k) {
    state_.rigid_position_m[driven_[k]] = Vector4(poses_[k].position_m);
    state_.orientation[driven_[k]] = Vector4(poses_[k].orientation);
  }
  ++state_.tick;
}

}  // namespace stillgrid::dynamics
