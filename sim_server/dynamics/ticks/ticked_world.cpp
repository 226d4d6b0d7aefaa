#include "sim_server/dynamics/ticks/ticked_world.hpp"

#include <utility>

namespace stillgrid::dynamics {
namespace {

bool is_finite(const SceneState& state) {
  Vector4 sum;
  for (const auto* values : state.vectors())
    for (const Vector4& value : *values) sum = sum + value;
  return (0.0 * sum.vector()).allFinite();
}

}  // namespace

TickedWorld::TickedWorld(DescribedWorld from, const bodies::World& world, EngineMethod method)
    : prescribed_(from.prescribed),
      sleeper_of_body_(std::move(from.sleeper_of_body)),
      ticks_(model_of(std::move(from), world), world.time_s, method),
      has_end_forces_(method.has_end_forces),
      before_(ticks_.engine().reactions().size()) {}

void TickedWorld::read_from(const bodies::World& world) {
  SceneState state = ticks_.engine().state();
  bool differs = false;
  const auto set = [&](Vector4& to, const Vector4& from) {
    differs = differs || to.x != from.x || to.y != from.y || to.z != from.z || to.w != from.w;
    to = from;
  };
  for (std::size_t i = 0; i < world.nodes.size(); ++i) {
    set(state.node_position_m[i], Vector4(world.nodes[i].position_m));
    set(state.node_velocity_m_s[i], Vector4(world.nodes[i].velocity_m_s));
  }
  for (std::size_t r = 0; r < world.rigid_bodies.size(); ++r) {
    const bodies::RigidBody& body = world.rigid_bodies[r];
    set(state.rigid_position_m[r], Vector4(body.position_m));
    set(state.orientation[r], Vector4(body.orientation));
    if (!body.free) continue;
    set(state.rigid_velocity_m_s[r], Vector4(body.velocity_m_s));
    set(state.angular_velocity_rad_s[r], Vector4(body.angular_velocity_rad_s));
  }
  if (differs) ticks_.engine().set_state(std::move(state));
  ticks_.engine().set_gravity(world.gravity_m_s2);
  ticks_.set_time(world.time_s);
  for (std::size_t k = 0; k < prescribed_.size(); ++k)
    ticks_.set_prescribed(k, world.rigid_bodies[prescribed_[k]].prescribed);
}

void TickedWorld::load(std::span<const std::byte> state) {
  ticks_.engine().load(state);
  ticks_.engine().set_state(ticks_.engine().state());
}

namespace {

DrivenReaction sum_of(double share, const DrivenReaction& a, double other,
                      const DrivenReaction& b) {
  return {share * a.impulse_N_s + other * b.impulse_N_s,
          share * a.moment_N_m_s + other * b.moment_N_m_s,
          share * a.rigid_impulse_N_s + other * b.rigid_impulse_N_s,
          share * a.rigid_moment_N_m_s + other * b.rigid_moment_N_m_s};
}

}  // namespace

/// Driven bodies move evenly within a tick: the work of their reactions is a product. The reaction
/// of an implicit step is the force at its end, and what moves the body has the mean of both ends.
void TickedWorld::add_flow(double tick_s, EnergyFlow& flow) {
  const SceneState& state = ticks_.engine().state();
  const auto along_J = [&](std::size_t rigid, const Eigen::Vector3d& impulse_N_s,
                           const Eigen::Vector3d& moment_N_m_s) {
    return -impulse_N_s.dot(state.rigid_velocity_m_s[rigid].vector()) -
           moment_N_m_s.dot(state.angular_velocity_rad_s[rigid].vector());
  };
  // The world gets what is not given to other driven bodies.
  const auto work_J = [&](std::size_t driven, std::size_t rigid) {
    const DrivenReaction& end = ticks_.engine().reactions()[driven];
    const DrivenReaction reaction =
        has_end_forces_ ? sum_of(0.5, end, 0.5 * tick_s, before_[driven]) : end;
    before_[driven] = sum_of(1.0 / tick_s, end, 0.0, end);
    const double all_J =
        end.brought_J + along_J(rigid, reaction.impulse_N_s, reaction.moment_N_m_s);
    flow.proxies_J += end.aimed_J;
    flow.given_J += end.aimed_J + all_J -
                    along_J(rigid, reaction.rigid_impulse_N_s, reaction.rigid_moment_N_m_s);
    return all_J;
  };
  for (std::size_t hand = 0; hand < ticks_.hands() && hand < flow.tool_J.size(); ++hand)
    flow.tool_J[hand] += work_J(ticks_.driven_of_hand(hand), ticks_.rigid_of_hand(hand));
  for (std::size_t k = 0; k < prescribed_.size(); ++k) work_J(k, prescribed_[k]);
  const EnergyLosses& losses = ticks_.engine().losses();
  flow.spring_damping_J += losses.spring_damping_J;
  flow.contact_damping_J += losses.contact_damping_J;
  flow.friction_J += losses.friction_J;
  flow.unsolved_J += losses.unsolved_J;
}

TickedWorld::Report TickedWorld::advance(const Tick& tick) {
  const bool slept = ticks_.engine().sleep().all_sleep();
  ticks_.step(tick);
  Report report{.substeps = ticks_.engine().substeps(),
                .touching = ticks_.engine().touching(),
                .solve = ticks_.engine().solve(),
                .sleep_loss_J = ticks_.engine().sleep().loss_J(),
                .all_slept = slept && ticks_.engine().sleep().all_sleep(),
                .counted_ns = ticks_.counted_ns()};
  add_flow(tick.length_s, report.flow);
  return report;
}

bool TickedWorld::write_to(bodies::World& world) const {
  const SceneState& state = ticks_.engine().state();
  if (!is_finite(state)) return false;
  world.time_s = ticks_.time_s();
  for (std::size_t i = 0; i < world.nodes.size(); ++i) {
    world.nodes[i].position_m = state.node_position_m[i].vector();
    world.nodes[i].velocity_m_s = state.node_velocity_m_s[i].vector();
  }
  for (std::size_t r = 0; r < world.rigid_bodies.size(); ++r) {
    bodies::RigidBody& body = world.rigid_bodies[r];
    body.position_m = state.rigid_position_m[r].vector();
    body.orientation = state.orientation[r].quaternion();
    body.velocity_m_s = state.rigid_velocity_m_s[r].vector();
    body.angular_velocity_rad_s = state.angular_velocity_rad_s[r].vector();
    if (!body.free)
      body.velocity_m_s = bodies::prescribed_state(body, ticks_.time_s()).velocity_m_s;
  }
  return true;
}

bool TickedWorld::write_sleep(bodies::World& world) {
  bool changed = false;
  sleeping_spheres_ = 0;
  for (std::size_t b = 0; b < sleeper_of_body_.size(); ++b) {
    const int sleeper = sleeper_of_body_[b];
    const bool sleeps =
        sleeper >= 0 && ticks_.engine().sleep().is_sleeping(static_cast<std::size_t>(sleeper));
    changed = changed || sleeps != world.bodies[b].is_sleeping;
    world.bodies[b].is_sleeping = sleeps;
    if (sleeps) sleeping_spheres_ += world.bodies[b].sphere_count;
  }
  return changed;
}

}  // namespace stillgrid::dynamics
