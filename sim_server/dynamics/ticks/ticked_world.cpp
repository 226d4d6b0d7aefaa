#include "sim_server/dynamics/ticks/ticked_world.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "shared/dynamics/rigid_motion.hpp"

namespace stillgrid::dynamics {

TickedWorld::TickedWorld(const bodies::World& world, std::span<const scene::Hand> hands) {
  DescribedWorld from = described(world, hands);
  prescribed_ = std::move(from.prescribed);
  first_hand_ = prescribed_.size() + (from.has_static_body ? 1 : 0);
  driven_.resize(first_hand_ + hands.size());
  before_.resize(hands.size());
  for (std::size_t k = 0; k < prescribed_.size(); ++k)
    driven_[k].orientation = world.rigid_bodies[prescribed_[k]].orientation;
  engine_ = std::make_unique<Engine>(std::move(from.description), std::move(from.state));
}

/// Where driven bodies are at time_s, when a share of the step is over.
void TickedWorld::aim(const bodies::World& world, double time_s, double share,
                      std::span<const std::optional<ToolPose>> tools) {
  for (std::size_t k = 0; k < prescribed_.size(); ++k)
    driven_[k].position_m =
        bodies::prescribed_state(world.rigid_bodies[prescribed_[k]], time_s).position_m;
  for (std::size_t hand = 0; hand < before_.size(); ++hand) {
    DrivenPose& pose = driven_[first_hand_ + hand];
    pose.is_here = hand < tools.size() && tools[hand].has_value();
    if (!pose.is_here) continue;
    const ToolPose &from = *before_[hand], &to = *tools[hand];
    pose.position_m = from.position_m + share * (to.position_m - from.position_m);
    pose.velocity_m_s = to.velocity_m_s;
    pose.orientation =
        rotation_by(share * rotation_vector(to.orientation * from.orientation.conjugate())) *
        from.orientation;
  }
}

/// Driven bodies move evenly within a tick, so that their reactions' work is a product.
void TickedWorld::add_work(Report& report) const {
  const SceneState& state = engine_->state();
  const std::size_t first = state.rigid_position_m.size() - before_.size();
  const auto along = [&](std::size_t rigid, const Eigen::Vector3d& impulse,
                         const Eigen::Vector3d& moment) {
    return -impulse.dot(state.rigid_velocity_m_s[rigid].vector()) -
           moment.dot(state.angular_velocity_rad_s[rigid].vector());
  };
  const auto work_J = [&](const DrivenReaction& reaction, std::size_t rigid) {
    return reaction.brought_J + along(rigid, reaction.impulse_N_s, reaction.moment_N_m_s);
  };
  const auto to_driven_J = [&](const DrivenReaction& reaction, std::size_t rigid) {
    return along(rigid, reaction.rigid_impulse_N_s, reaction.rigid_moment_N_m_s);
  };
  const auto reactions = engine_->reactions();
  for (std::size_t hand = 0; hand < before_.size() && hand < report.work_J.size(); ++hand) {
    report.work_J[hand] += work_J(reactions[first_hand_ + hand], first + hand);
    report.to_driven_J += to_driven_J(reactions[first_hand_ + hand], first + hand);
  }
  for (std::size_t k = 0; k < prescribed_.size(); ++k)
    report.prescribed_work_J +=
        work_J(reactions[k], prescribed_[k]) - to_driven_J(reactions[k], prescribed_[k]);
}

void TickedWorld::write_to(bodies::World& world) const {
  const SceneState& state = engine_->state();
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
    if (!body.free) body.velocity_m_s = bodies::prescribed_state(body, world.time_s).velocity_m_s;
  }
}

TickedWorld::Report TickedWorld::step(bodies::World& world, double step_s,
                                      std::span<const std::optional<ToolPose>> tools) {
  constexpr double kRounding = 1e-9;  // of a step that is a multiple of a tick
  const int ticks = std::max(1, static_cast<int>(std::ceil(step_s / kTick_s - kRounding)));
  const double tick_s = step_s / ticks;
  for (std::size_t hand = 0; hand < before_.size() && hand < tools.size(); ++hand) {
    if (before_[hand] || !tools[hand]) continue;
    before_[hand] = tools[hand];  // it comes at its velocity
    before_[hand]->position_m -= step_s * tools[hand]->velocity_m_s;
  }
  Report report;
  for (int tick = 1; tick <= ticks; ++tick) {
    aim(world, world.time_s + tick * tick_s, tick / static_cast<double>(ticks), tools);
    engine_->step(driven_, tick_s);
    add_work(report);
    report.substeps += engine_->substeps();
    report.losses += engine_->losses();
  }
  for (std::size_t hand = 0; hand < before_.size(); ++hand)
    before_[hand] = hand < tools.size() ? tools[hand] : std::nullopt;
  world.time_s += step_s;
  write_to(world);
  report.touching = engine_->touching();
  return report;
}

}  // namespace stillgrid::dynamics
