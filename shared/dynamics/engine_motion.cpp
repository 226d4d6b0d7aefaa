// How nodes and rigid bodies move within a substep.
#include <algorithm>

#include "shared/dynamics/at.hpp"
#include "shared/dynamics/engine.hpp"
#include "shared/dynamics/rigid_motion.hpp"

namespace stillgrid::dynamics {
namespace {

/// How much `now` is more than the float that `before` was rounded to.
Vector4 change_since(const Vector4& before, const float (&now)[3]) {
  return {now[0] - static_cast<float>(before.x), now[1] - static_cast<float>(before.y),
          now[2] - static_cast<float>(before.z)};
}

}  // namespace

void Engine::drift(double h) {
  for (const auto& [first, end] : awake_nodes_)
    for (std::size_t i = first; i < end; ++i)
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
  for (const std::int32_t node : listed_nodes_)
    set_vector(bodies_.movers[at(node)].velocity_m_s, state_.node_velocity_m_s[at(node)]);
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

/// At the velocities of the state.
void Engine::sum_forces() {
  for (const auto& [first, end] : awake_nodes_)
    std::fill_n(forces_N_.begin() + static_cast<std::ptrdiff_t>(first), end - first, Vector4());
  springs_.add_forces(state_.node_position_m, state_.node_velocity_m_s, forces_N_, *live_.sharing);
  std::fill(wrenches_.begin(), wrenches_.end(), Wrench());
  add_joint_forces(awake_joints_, state_, forces_N_, wrenches_);
}

void Engine::apply_forces(double h, const Vector4& falls) {
  each_awake_node([&](std::size_t i) {
    if (description_.nodes[i].is_pinned) return;
    Vector4& velocity = state_.node_velocity_m_s[i];
    velocity = velocity + (h / description_.nodes[i].mass_kg) * forces_N_[i];
    velocity = velocity + falls;
  });
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
  apply_forces(h, falls);
  for (const std::int32_t node : listed_nodes_)
    set_vector(bodies_.movers[at(node)].velocity_m_s, state_.node_velocity_m_s[at(node)]);
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
  for (const std::int32_t node : listed_nodes_) {
    Vector4& velocity = state_.node_velocity_m_s[at(node)];
    velocity = velocity + change_since(velocity, bodies_.movers[at(node)].velocity_m_s);
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

}  // namespace stillgrid::dynamics
