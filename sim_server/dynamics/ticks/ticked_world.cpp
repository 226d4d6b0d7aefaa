#include "sim_server/dynamics/ticks/ticked_world.hpp"

#include <utility>

#include "shared/dynamics/rigid_motion.hpp"

namespace stillgrid::dynamics {
namespace {

bool is_finite(const SceneState& state) {
  Vector4 sum;
  for (const auto* values :
       {&state.node_position_m, &state.node_velocity_m_s, &state.rigid_position_m,
        &state.rigid_velocity_m_s, &state.orientation, &state.angular_velocity_rad_s})
    for (const Vector4& value : *values) sum = sum + value;
  return (0.0 * sum.vector()).allFinite();
}

}  // namespace

TickedWorld::TickedWorld(const bodies::World& world, std::span<const scene::Hand> hands,
                         bool may_sleep, EngineMethod method)
    : hands_(hands.size()), time_s_(world.time_s), has_end_forces_(method.has_end_forces) {
  DescribedWorld from = described(world, hands, may_sleep);
  sleeper_of_body_ = std::move(from.sleeper_of_body);
  prescribed_ = std::move(from.prescribed);
  first_hand_ = prescribed_.size() + (from.has_static_body ? 1 : 0);
  driven_.resize(first_hand_ + hands_);
  before_.resize(driven_.size());
  for (std::size_t k = 0; k < prescribed_.size(); ++k)
    driven_[k].orientation = world.rigid_bodies[prescribed_[k]].orientation;
  engine_ = std::make_unique<Engine>(std::move(from.description), std::move(from.state), method);
}

void TickedWorld::read_from(const bodies::World& world) {
  SceneState state = engine_->state();
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
  if (differs) engine_->set_state(std::move(state));
  engine_->set_gravity(world.gravity_m_s2);
  time_s_ = world.time_s;
}

void TickedWorld::load(std::span<const std::byte> state) {
  engine_->load(state);
  engine_->set_state(engine_->state());
}

/// Tools are the last rigid bodies.
std::size_t TickedWorld::rigid_of_hand(std::size_t hand) const {
  return engine_->state().rigid_position_m.size() - hands_ + hand;
}

/// Where driven bodies are at the end of the tick.
void TickedWorld::aim(const bodies::World& world, const Tick& tick) {
  const SceneState& state = engine_->state();
  for (std::size_t k = 0; k < prescribed_.size(); ++k)
    driven_[k].position_m =
        bodies::prescribed_state(world.rigid_bodies[prescribed_[k]], time_s_ + tick.length_s)
            .position_m;
  for (std::size_t hand = 0; hand < hands_; ++hand) {
    DrivenPose& pose = driven_[first_hand_ + hand];
    pose.is_here = hand < tick.tools.size() && tick.tools[hand].has_value();
    if (!pose.is_here) continue;
    const ToolPose& end = *tick.tools[hand];
    const std::size_t r = rigid_of_hand(hand);
    // A tool comes at its velocity.
    const bool comes = state.is_here[r] == 0;
    const Eigen::Vector3d from_m =
        comes ? Eigen::Vector3d(end.position_m - tick.left_s * end.velocity_m_s)
              : state.rigid_position_m[r].vector();
    const Eigen::Quaterniond from = comes ? end.orientation : state.orientation[r].quaternion();
    const double share = tick.length_s / tick.left_s;
    pose.position_m = from_m + share * (end.position_m - from_m);
    pose.orientation =
        rotation_by(share * rotation_vector(end.orientation * from.conjugate())) * from;
    pose.velocity_m_s = end.velocity_m_s;
    if (share < 1.0) continue;
    pose.position_m = end.position_m;
    pose.orientation = end.orientation;
  }
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
  const SceneState& state = engine_->state();
  const auto along_J = [&](std::size_t rigid, const Eigen::Vector3d& impulse_N_s,
                           const Eigen::Vector3d& moment_N_m_s) {
    return -impulse_N_s.dot(state.rigid_velocity_m_s[rigid].vector()) -
           moment_N_m_s.dot(state.angular_velocity_rad_s[rigid].vector());
  };
  // The world gets what is not given to other driven bodies.
  const auto work_J = [&](std::size_t driven, std::size_t rigid) {
    const DrivenReaction& end = engine_->reactions()[driven];
    const DrivenReaction reaction =
        has_end_forces_ ? sum_of(0.5, end, 0.5 * tick_s, before_[driven]) : end;
    before_[driven] = sum_of(1.0 / tick_s, end, 0.0, end);
    const double all_J =
        end.brought_J + along_J(rigid, reaction.impulse_N_s, reaction.moment_N_m_s);
    flow.given_J += all_J - along_J(rigid, reaction.rigid_impulse_N_s, reaction.rigid_moment_N_m_s);
    return all_J;
  };
  for (std::size_t hand = 0; hand < hands_ && hand < flow.tool_J.size(); ++hand)
    flow.tool_J[hand] += work_J(first_hand_ + hand, rigid_of_hand(hand));
  for (std::size_t k = 0; k < prescribed_.size(); ++k) work_J(k, prescribed_[k]);
  const EnergyLosses& losses = engine_->losses();
  flow.spring_damping_J += losses.spring_damping_J;
  flow.contact_damping_J += losses.contact_damping_J;
  flow.friction_J += losses.friction_J;
  flow.unsolved_J += losses.unsolved_J;
}

TickedWorld::Report TickedWorld::advance(const bodies::World& world, const Tick& tick) {
  aim(world, tick);
  const bool slept = engine_->sleep().all_sleep();
  engine_->step(driven_, tick.length_s, tick.substeps);
  time_s_ += tick.length_s;
  Report report{.substeps = engine_->substeps(),
                .touching = engine_->touching(),
                .solve = engine_->solve(),
                .sleep_loss_J = engine_->sleep().loss_J(),
                .all_slept = slept && engine_->sleep().all_sleep()};
  add_flow(tick.length_s, report.flow);
  return report;
}

bool TickedWorld::write_to(bodies::World& world) const {
  const SceneState& state = engine_->state();
  if (!is_finite(state)) return false;
  world.time_s = time_s_;
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
    if (!body.free) body.velocity_m_s = bodies::prescribed_state(body, time_s_).velocity_m_s;
  }
  return true;
}

bool TickedWorld::write_sleep(bodies::World& world) {
  bool changed = false;
  sleeping_spheres_ = 0;
  for (std::size_t b = 0; b < sleeper_of_body_.size(); ++b) {
    const int sleeper = sleeper_of_body_[b];
    const bool sleeps =
        sleeper >= 0 && engine_->sleep().is_sleeping(static_cast<std::size_t>(sleeper));
    changed = changed || sleeps != world.bodies[b].is_sleeping;
    world.bodies[b].is_sleeping = sleeps;
    if (sleeps) sleeping_spheres_ += world.bodies[b].sphere_count;
  }
  if (changed) bodies::number_unknowns(world);
  return changed;
}

}  // namespace stillgrid::dynamics
