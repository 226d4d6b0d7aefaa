#include "shared/dynamics/engine.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "shared/dynamics/rigid_motion.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr int kIterations = 2;  // of a substep, one in each direction

std::size_t at(std::int32_t index) {
  return static_cast<std::size_t>(index);
}

Description validated(Description description) {
  validate(description);
  return description;
}

/// Position Verlet is stable where (h w)^2 / 4 + h d / 2 < 1 for the fastest vibration w and the
/// strongest damper d; both are bounds already.
int substeps_for(const SpectrumBound& bound) {
  constexpr double kMost = 0.9;
  for (int substeps = 1;; ++substeps) {
    const double h = kTick_s / substeps, turn = h * bound.frequency_rad_s;
    if (0.25 * turn * turn + 0.5 * h * bound.damping_per_s <= kMost) return substeps;
  }
}

void set_velocity(Mover& mover, const Vector4& velocity) {
  mover.velocity_m_s[0] = static_cast<float>(velocity.x);
  mover.velocity_m_s[1] = static_cast<float>(velocity.y);
  mover.velocity_m_s[2] = static_cast<float>(velocity.z);
}
/// How much `now` is more than the float that `before` was rounded to.
Vector4 change_since(const Vector4& before, const float (&now)[3]) {
  return {now[0] - static_cast<float>(before.x), now[1] - static_cast<float>(before.y),
          now[2] - static_cast<float>(before.z)};
}

}  // namespace

Engine::Engine(Description description, SceneState state)
    : description_(validated(std::move(description))),
      state_(std::move(state)),
      springs_(description_),
      listing_(description_),
      forces_N_(description_.nodes.size()),
      ball_radius_m_(description_.rigid_bodies.size()),
      driven_of_rigid_(description_.rigid_bodies.size(), -1),
      substeps_(substeps_for(spectrum_bound(description_))) {
  for (std::size_t s = 0; s < description_.spheres.size(); ++s)
    if (listing_.kinds()[s] == SideKind::kBall)
      ball_radius_m_[at(description_.spheres[s].rigid)] = description_.spheres[s].radius_m;
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
  bodies_.inverse_inertias.resize(movers);
  bodies_.places.resize(description_.spheres.size());
  bodies_.arms.resize(description_.spheres.size());
}

void Engine::aim_driven(std::span<const DrivenPose> driven) {
  assert(driven.size() == driven_.size());
  for (std::size_t k = 0; k < driven_.size(); ++k) {
    const std::size_t r = driven_[k];
    poses_[k] = driven[k];
    reactions_[k] = {};
    const std::uint8_t is_here = driven[k].is_here ? 1 : 0;
    is_stale_ = is_stale_ || is_here != state_.is_here[r];
    if (is_here > state_.is_here[r]) {
      state_.rigid_position_m[r] =
          Vector4(driven[k].position_m - kTick_s * driven[k].velocity_m_s);
      state_.orientation[r] = Vector4(driven[k].orientation);
    }
    state_.is_here[r] = is_here;
    const Vector4 way = Vector4(driven[k].position_m) - state_.rigid_position_m[r];
    state_.rigid_velocity_m_s[r] = (is_here != 0 ? 1.0 / kTick_s : 0.0) * way;
    const Eigen::AngleAxisd turn(driven[k].orientation *
                                 state_.orientation[r].quaternion().conjugate());
    state_.angular_velocity_rad_s[r] =
        (is_here != 0 ? 1.0 / kTick_s : 0.0) * Vector4(turn.angle() * turn.axis());
  }
}

void Engine::drift(double h) {
  for (std::size_t i = 0; i < state_.node_position_m.size(); ++i)
    state_.node_position_m[i] = state_.node_position_m[i] + h * state_.node_velocity_m_s[i];
  for (std::size_t r = 0; r < state_.rigid_position_m.size(); ++r) {
    state_.rigid_position_m[r] = state_.rigid_position_m[r] + h * state_.rigid_velocity_m_s[r];
    if (ball_radius_m_[r] > 0.0) continue;
    Eigen::Quaterniond orientation = state_.orientation[r].quaternion();
    Eigen::Vector3d spin = state_.angular_velocity_rad_s[r].vector();
    const Description::Rigid& rigid = description_.rigid_bodies[r];
    if (rigid.is_driven)
      orientation = turned(orientation, spin, h);
    else
      turn_freely(orientation, spin, rigid.inertia_kg_m2, h);
    state_.orientation[r] = Vector4(orientation);
    state_.angular_velocity_rad_s[r] = Vector4(spin);
  }
}

/// Orientations of balls act on nothing, so that once a tick is often enough.
void Engine::turn_balls() {
  for (std::size_t r = 0; r < ball_radius_m_.size(); ++r)
    if (ball_radius_m_[r] > 0.0)
      state_.orientation[r] = Vector4(turned(state_.orientation[r].quaternion(),
                                             state_.angular_velocity_rad_s[r].vector(), kTick_s));
}

void Engine::load_movers() {
  const std::size_t nodes = state_.node_position_m.size();
  for (std::size_t i = 0; i < nodes; ++i) {
    const Description::Node& node = description_.nodes[i];
    set_velocity(bodies_.movers[i], state_.node_velocity_m_s[i]);
    bodies_.movers[i].inverse_mass_per_kg =
        node.is_pinned ? 0.0F : static_cast<float>(1.0 / node.mass_kg);
  }
  const auto order = listing_.rigid_order();
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::size_t r = at(order[k]);
    const Description::Rigid& rigid = description_.rigid_bodies[r];
    Mover& mover = bodies_.movers[nodes + k];
    set_velocity(mover, state_.rigid_velocity_m_s[r]);
    mover.inverse_mass_per_kg = rigid.is_driven ? 0.0F : static_cast<float>(1.0 / rigid.mass_kg);
    const bool is_ball = ball_radius_m_[r] > 0.0;
    const Vector4 spin = (is_ball ? ball_radius_m_[r] : 1.0) * state_.angular_velocity_rad_s[r];
    mover.spin[0] = static_cast<float>(spin.x);
    mover.spin[1] = static_cast<float>(spin.y);
    mover.spin[2] = static_cast<float>(spin.z);
    if (is_ball) continue;
    InverseInertia& inverse = bodies_.inverse_inertias[nodes + k];
    inverse = {};
    if (rigid.is_driven) continue;
    const Eigen::Matrix3f m =
        inverse_inertia(state_.orientation[r].quaternion(), rigid.inertia_kg_m2).cast<float>();
    inverse = {m(0, 0), m(0, 1), m(0, 2), 0.0F, m(1, 1), m(1, 2), m(2, 2), 0.0F};
  }
}

void Engine::place_spheres(double h) {
  const double falls = h * h * description_.gravity_m_s2.norm();
  const auto order = listing_.order();
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::size_t s = at(order[k]);
    const Description::Sphere& sphere = description_.spheres[s];
    Vector4 centre;
    double speed = 0.0;
    if (sphere.rigid >= 0) {
      const std::size_t r = at(sphere.rigid);
      centre = state_.rigid_position_m[r];
      speed = std::sqrt(state_.rigid_velocity_m_s[r].vector().squaredNorm());
      if (listing_.kinds()[s] != SideKind::kBall) {
        const Eigen::Vector3d arm = state_.orientation[r].quaternion() * sphere.local_m;
        centre = centre + Vector4(arm);
        speed += std::sqrt(state_.angular_velocity_rad_s[r].vector().squaredNorm() *
                           arm.squaredNorm());
        bodies_.arms[k] = {{static_cast<float>(arm.x()), static_cast<float>(arm.y()),
                            static_cast<float>(arm.z())},
                           static_cast<float>(sphere.radius_m)};
      }
    } else {
      double most = 0.0;
      for (std::size_t n = 0; n < at(sphere.node_count); ++n) {
        const std::size_t node = at(sphere.nodes[n]);
        centre = centre + sphere.weights[n] * state_.node_position_m[node];
        most = std::max(most, state_.node_velocity_m_s[node].vector().squaredNorm());
      }
      speed = std::sqrt(most);
    }
    const Vector4& base = listing_.base()[s];
    bodies_.places[k] = {{static_cast<float>(centre.x - base.x),
                          static_cast<float>(centre.y - base.y),
                          static_cast<float>(centre.z - base.z)},
                         static_cast<float>(h * speed + falls)};
  }
}

/// Whether no sphere leaves its reach within the tick.
bool Engine::listing_holds() {
  if (is_stale_) return false;
  place_spheres(kTick_s);
  const auto order = listing_.order();
  bool holds = true;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const SpherePlace& place = bodies_.places[k];
    const float x = place.moved_m[0], y = place.moved_m[1], z = place.moved_m[2];
    const double way = std::sqrt(x * x + y * y + z * z) + place.reach_m;
    holds = holds && way < listing_.base()[at(order[k])].w;
  }
  return holds;
}

void Engine::kick(double h) {
  std::fill(forces_N_.begin(), forces_N_.end(), Vector4());
  springs_.add_forces(state_.node_position_m, state_.node_velocity_m_s, forces_N_);
  const Vector4 falls = h * Vector4(description_.gravity_m_s2);
  const std::size_t nodes = forces_N_.size();
  for (std::size_t i = 0; i < nodes; ++i) {
    if (description_.nodes[i].is_pinned) continue;
    Vector4& velocity = state_.node_velocity_m_s[i];
    velocity = velocity + (h / description_.nodes[i].mass_kg) * forces_N_[i] + falls;
    set_velocity(bodies_.movers[i], velocity);
  }
  const auto order = listing_.rigid_order();
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (description_.rigid_bodies[at(order[k])].is_driven) continue;
    Vector4& velocity = state_.rigid_velocity_m_s[at(order[k])];
    velocity = velocity + falls;
    set_velocity(bodies_.movers[nodes + k], velocity);
  }
}

/// Floats carry only the changes of a substep, so that velocities keep all their digits.
void Engine::apply_impulses() {
  const std::size_t nodes = forces_N_.size();
  for (std::size_t i = 0; i < nodes; ++i) {
    Vector4& velocity = state_.node_velocity_m_s[i];
    velocity = velocity + change_since(velocity, bodies_.movers[i].velocity_m_s);
  }
  const auto order = listing_.rigid_order();
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::size_t r = at(order[k]);
    if (driven_of_rigid_[r] >= 0) continue;
    Vector4 &velocity = state_.rigid_velocity_m_s[r], &spin = state_.angular_velocity_rad_s[r];
    velocity = velocity + change_since(velocity, bodies_.movers[nodes + k].velocity_m_s);
    const double radius = ball_radius_m_[r] > 0.0 ? ball_radius_m_[r] : 1.0;
    spin = spin + 1.0 / radius * change_since(radius * spin, bodies_.movers[nodes + k].spin);
  }
}

void Engine::note_reactions() {
  const RowList& list = listing_.rows();
  const auto note = [&](std::int32_t mover, const RigidSide& side, std::size_t lane, double sign,
                        const ContactRow& row) {
    const std::size_t k = at(mover) - forces_N_.size();
    const auto order = listing_.rigid_order();
    if (k >= order.size() || driven_of_rigid_[at(order[k])] < 0) return;
    DrivenReaction& reaction = reactions_[at(driven_of_rigid_[at(order[k])])];
    const auto vector = [&](const RowFloats(&v)[3]) {
      return Eigen::Vector3d(v[0][lane], v[1][lane], v[2][lane]);
    };
    const Eigen::Vector3d impulse =
        sign * (row.push_N_s[lane] * vector(row.normal) + vector(row.drag_N_s));
    reaction.impulse_N_s += impulse;
    reaction.moment_N_m_s += vector(side.arm_m).cross(impulse);
  };
  for (std::size_t g = 0, i = 0; g < list.groups.size(); ++g) {
    const RowGroup& group = list.groups[g];
    for (; i < live_.group_end[g]; ++i) {
      const std::size_t index = live_.rows[i], k = index - group.first;
      const ContactRow& row = list.rows[index];
      for (std::size_t lane = 0; lane < kRowLanes; ++lane) {
        if (row.push_N_s[lane] == 0.0F) continue;
        if (group.a == SideKind::kRigid)
          note(row.mover_a[lane], list.rigid_sides[group.first_side_a + k], lane, 1.0, row);
        if (group.b == SideKind::kRigid)
          note(row.mover_b[lane], list.rigid_sides[group.first_side_b + k], lane, -1.0, row);
      }
    }
  }
}

void Engine::substep(double h) {
  RowList& rows = listing_.rows();
  const auto step = static_cast<float>(h);
  drift(0.5 * h);
  load_movers();
  place_spheres(h);
  prepare_rows(rows, bodies_, step, live_);
  kick(h);
  warm_start_rows(rows, bodies_, live_);
  for (int k = 0; k < kIterations; ++k) solve_rows(rows, bodies_, live_, k % 2 == 1);
  finish_rows(rows, step, live_);
  apply_impulses();
  if (!driven_.empty()) note_reactions();
  drift(0.5 * h);
}

void Engine::step(std::span<const DrivenPose> driven) {
  aim_driven(driven);
  if (!listing_holds()) {
    listing_.list(state_, kTick_s);
    is_stale_ = false;
  }
  for (int k = 0; k < substeps_; ++k) substep(kTick_s / substeps_);
  turn_balls();
  for (std::size_t k = 0; k < driven_.size(); ++k) {
    state_.rigid_position_m[driven_[k]] = Vector4(poses_[k].position_m);
    state_.orientation[driven_[k]] = Vector4(poses_[k].orientation);
  }
  ++state_.tick;
}

}  // namespace stillgrid::dynamics
