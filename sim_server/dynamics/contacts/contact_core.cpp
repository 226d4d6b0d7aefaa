#include "sim_server/dynamics/contacts/contact_core.hpp"

#include <algorithm>

#include "sim_server/contact/sticking.hpp"

namespace stillgrid::dynamics {
namespace {

using Eigen::Vector3d;

double spin_about(const Vector3d& normal, const TouchSide& side, const ExplicitState& state) {
  if (side.rigid < 0) return 0.0;
  return normal.dot(state.rigid[static_cast<std::size_t>(side.rigid)].spin_rad_s);
}

}  // namespace

void ContactCore::take(const bodies::World& world, std::span<const contact::Contact> contacts) {
  list_.take(world, contacts);
  touches_.clear();
  struck_ = false;
}

void ContactCore::begin(double share, double part_s, double substep_s, const Vector3d& gravity_m_s2,
                        const ExplicitState& state) {
  list_.place(state, substep_s, gravity_m_s2);
  movers_.clear(list_.spheres(), state);
  near_.clear();
  moved_.clear();
  for (std::size_t i = 0; i < list_.pairs().size(); ++i) {
    const ContactPair& pair = list_.pairs()[i];
    if (!list_.is_near(pair, share, part_s, substep_s)) {
      list_.memories().forget(i);
      continue;
    }
    near_.push_back(i);
    int moved = movers_.enter(*list_.sphere(pair.a).binding, -1, state);
    if (pair.b >= 0) moved = movers_.enter(*list_.sphere(pair.b).binding, moved, state);
    moved_.push_back(moved);
  }
  movers_.divide(moved_, place_of_, state);
  sorted_.resize(near_.size());
  for (std::size_t i = 0; i < near_.size(); ++i) sorted_[place_of_[i]] = near_[i];
  touches_.clear();
  for (std::size_t i = 0; i < movers_.islands().size(); ++i) {
    movers_.begin_island(i);
    for (std::size_t k = touches_.size(); k < movers_.islands()[i].touches.last; ++k)
      touches_.push_back(touch_of(sorted_[k], share, part_s, substep_s, state));
  }
  fill_rows(substep_s, state);
}

void ContactCore::fill_rows(double substep_s, const ExplicitState& state) {
  std::size_t next = 0;
  for (const ContactIsland& island : movers_.islands()) {
    next = (next + ContactRows::kLanes - 1) / ContactRows::kLanes * ContactRows::kLanes;
    for (std::size_t i = island.touches.first; i < island.touches.last; ++i, ++next) {
      Touch& touch = touches_[i];
      touch.row = next;
      if (next % ContactRows::kLanes == 0) {
        rows_.resize(next / ContactRows::kLanes);
        rows_.emplace_back();
      }
      ContactRows& rows = rows_.back();
      const std::size_t lane = next % ContactRows::kLanes;
      rows.a[lane] = touch.a.point;
      rows.b[lane] = touch.b.point;
      Vector3d given_m_s = touch.given_m_s;
      if (touch.a.point == 0) given_m_s -= velocity_m_s(touch.a, state);
      if (touch.b.point == 0) given_m_s += velocity_m_s(touch.b, state);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        rows.arm_a_m[axis][lane] = touch.a.point == 0 ? 0.0 : touch.a.arm_m[k];
        rows.arm_b_m[axis][lane] = touch.b.point == 0 ? 0.0 : touch.b.arm_m[k];
      }
      rows.set(lane, touch.contact, given_m_s, substep_s);
    }
  }
}

ContactCore::Touch ContactCore::touch_of(std::size_t index, double share, double part_s,
                                         double substep_s, const ExplicitState& state) {
  const ContactPair& pair = list_.pairs()[index];
  const contact::Contact& contact = *pair.contact;
  const ContactSphere& a = list_.sphere(pair.a);
  Touch touch;
  touch.pair = index;
  SubstepContact& own = touch.contact;
  own.material = contact.material;
  own.is_viscous = contact.is_tool;
  Vector3d to_a_m, to_b_m = Vector3d::Zero();  // from the centres to the point of contact
  if (contact.is_plane) {
    own.normal = contact.plane_normal;
    own.depth_m = contact.radius_a_m - (own.normal.dot(a.position_m) - contact.plane_offset_m);
    to_a_m = -contact.radius_a_m * own.normal;
  } else {
    const Vector3d line_m = a.position_m - list_.other_m(pair, share);
    const double distance_m = line_m.norm();
    // Concentric spheres push along any one direction: up.
    own.normal = distance_m < 1e-12 ? Vector3d(Vector3d::UnitZ()) : Vector3d(line_m / distance_m);
    own.depth_m = pair.distance_m - distance_m;
    to_a_m = -pair.radius_m / pair.distance_m * line_m;
    to_b_m = line_m + to_a_m;
  }
  touch.a = movers_.side_of(pair.a, *a.binding, a.arm_m + to_a_m, state);
  if (pair.b >= 0) {
    const ContactSphere& b = list_.sphere(pair.b);
    touch.b = movers_.side_of(pair.b, *b.binding, b.arm_m + to_b_m, state);
  } else if (!contact.is_plane) {
    // Along the normal the way counts, across it what the tool's velocity says.
    const Vector3d point_m_s = contact.velocity_b_m_s + contact.spin_b_rad_s.cross(to_b_m);
    touch.given_m_s = point_m_s + own.normal.dot(way_m_s(contact, part_s) - point_m_s) * own.normal;
  }
  const double spin_rad_s =
      spin_about(own.normal, touch.a, state) + spin_about(own.normal, touch.b, state);
  ContactMemory& memory = list_.memories()[index];
  own.stretch_m =
      carried_stretch_m(memory.stretch_m, memory.normal, own.normal, 0.5 * substep_s * spin_rad_s);
  own.start_velocity_m_s = relative_velocity_m_s(touch, state);
  memory.normal = own.normal;
  return touch;
}

Vector3d ContactCore::relative_velocity_m_s(const Touch& touch, const ExplicitState& state) {
  return velocity_m_s(touch.a, state) - velocity_m_s(touch.b, state) - touch.given_m_s;
}

ContactSolve ContactCore::solve(double substep_s, const Budget& budget, ExplicitState& state,
                                EnergyFlow& flow) {
  ContactSolve worst;
  spring_change_J_ = stiffness_ratio_ = 0.0;
  flow.friction_J += list_.memories().take_parted_J();
  movers_.start(state);
  for (const ContactIsland& island : movers_.islands()) {
    const ContactSolve own = solve_island(island, substep_s, budget, state);
    worst.iterations = std::max(worst.iterations, own.iterations);
    worst.residual_m_s = std::max(worst.residual_m_s, own.residual_m_s);
    worst.converged = worst.converged && own.converged;
    worst.late = worst.late || own.late;
  }
  movers_.apply(state);
  finish(substep_s, state, flow);
  return worst;
}

/// What contacts did on the way that the substep really takes; what sticks on.
void ContactCore::finish(double substep_s, const ExplicitState& state, EnergyFlow& flow) {
  const auto is_given = [&](const TouchSide& side) {
    return side.rigid >= 0 && !state.rigid[static_cast<std::size_t>(side.rigid)].free;
  };
  for (const Touch& touch : touches_) {
    const SubstepContact& contact = touch.contact;
    ContactMemory& memory = list_.memories()[touch.pair];
    const ContactRows& rows = rows_[touch.row / ContactRows::kLanes];
    const std::size_t lane = touch.row % ContactRows::kLanes;
    const double spring_N = rows.spring_N[lane], damper_N = rows.damper_N[lane];
    const Vector3d impulse_N_s = rows.impulse_of(lane);
    const double normal_N = spring_N + damper_N;
    const Vector3d end_m_s = relative_velocity_m_s(touch, state);
    const Vector3d mean_m_s = 0.5 * (contact.start_velocity_m_s + end_m_s);
    const double apart_m_s = contact.normal.dot(mean_m_s);
    const double held_J = memory.energy_J();
    struck_ = struck_ || normal_N > 0.0;
    memory.stretch_m.setZero();
    if (normal_N > 0.0 && !contact.is_viscous && contact.material.friction > 0.0) {
      const Vector3d way_m = substep_s * (mean_m_s - apart_m_s * contact.normal);
      memory.stretch_m = contact::sticking_force(contact.material, contact.stretch_m, way_m,
                                                 contact.material.friction * normal_N, substep_s)
                             .stretch_m;
    }
    const double across_J = impulse_N_s.dot(mean_m_s) - substep_s * normal_N * apart_m_s;
    flow.contact_damping_J -= substep_s * damper_N * apart_m_s;
    flow.friction_J += held_J - memory.energy_J() - across_J;
    const double change_J =
        spring_energy_J(contact.material, end_depth_m(contact, end_m_s, substep_s)) -
        spring_energy_J(contact.material, start_depth_m(contact, substep_s));
    spring_change_J_ += change_J;
    flow.unsolved_J += change_J + substep_s * spring_N * apart_m_s;
    // Work against what is moved from outside.
    if (touch.b.rigid < 0 && touch.b.nodes == nullptr)
      flow.given_J += impulse_N_s.dot(touch.given_m_s);
    else if (is_given(touch.b))
      flow.given_J += impulse_N_s.dot(velocity_m_s(touch.b, state));
    if (is_given(touch.a)) flow.given_J -= impulse_N_s.dot(velocity_m_s(touch.a, state));
  }
}

}  // namespace stillgrid::dynamics
