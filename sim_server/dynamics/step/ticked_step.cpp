// A step by the engine of both processes.
#include <cmath>
#include <stdexcept>
#include <string>

#include "sim_server/dynamics/step/simulation.hpp"

namespace stillgrid::dynamics {
namespace {

bool is_finite(const bodies::World& world) {
  double sum = 0.0;
  for (const bodies::Node& node : world.nodes)
    sum += node.position_m.sum() + node.velocity_m_s.sum();
  for (const bodies::RigidBody& body : world.rigid_bodies)
    sum += body.position_m.sum() + body.velocity_m_s.sum() + body.angular_velocity_rad_s.sum();
  return std::isfinite(sum);
}

void note_losses(const EnergyLosses& losses, EnergyFlow& flow) {
  flow.spring_damping_J += losses.spring_damping_J;
  flow.contact_damping_J += losses.contact_damping_J;
  flow.friction_J += losses.friction_J;
  flow.unsolved_J += losses.unsolved_J;
}

}  // namespace

/// Tools come and go between steps, and move evenly within one.
StepReport Simulation::tick(Step& step) {
  const auto start = std::chrono::steady_clock::now();
  StepReport& report = step.report;
  place_tools(step);
  std::vector<std::optional<ToolPose>> poses(tools_.size());
  for (std::size_t hand = 0; hand < tools_.size(); ++hand) {
    if (!tools_[hand].is_here()) continue;
    const ToolSample& sample = tools_[hand].sample();
    poses[hand] = {sample.position_m, sample.orientation, sample.velocity_m_s};
  }
  if (watch_ && watch_->is_due(world_)) watch_->judge(world_, energies_now());
  const TickedWorld::Report ticked = ticked_->step(world_, step.length_s, poses);
  if (!is_finite(world_))
    throw std::domain_error("after " + std::to_string(world_.time_s) +
                            " s of simulated time a position or a velocity is not finite");
  double given_J = ticked.prescribed_work_J + ticked.losses.joints_J - ticked.to_driven_J;
  for (std::size_t hand = 0; hand < tools_.size(); ++hand) {
    tool_work_J_[hand] += ticked.work_J[hand];
    given_J += ticked.work_J[hand];
    report.tools[hand].work_J = tool_work_J_[hand];
  }
  if (account_) {
    account_->flow.given_J += given_J;
    note_losses(ticked.losses, account_->flow);
  }
  if (watch_) watch_->note_given(given_J);
  report.substeps = ticked.substeps;
  report.contacts = ticked.touching;
  detection_.move_spheres(world_);
  snapshot_.show(detection_);
  moving_fields_.show(world_);
  report.integrate = std::chrono::steady_clock::now() - start;
  return report;
}

}  // namespace stillgrid::dynamics
