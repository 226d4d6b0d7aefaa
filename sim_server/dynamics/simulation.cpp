#include "sim_server/dynamics/simulation.hpp"

#include "sim_server/dynamics/implicit_euler.hpp"

namespace stillgrid {

Simulation::Simulation(const SceneDescription& scene)
    : world_(build_world(scene)), detection_(world_, scene.voxel_ratio), tool_(scene.tool) {}

StepReport Simulation::step(double step_s,
                            const std::function<std::optional<ToolSample>()>& take_tool) {
  using Clock = std::chrono::steady_clock;
  StepReport report;
  const auto start = Clock::now();
  detection_.find_contacts(world_, step_s);
  if (const auto sample = take_tool()) {
    report.tool_time_ns = sample->time_ns;
    detection_.find_tool_contacts(world_, place_tool(*sample));
  }
  const auto detected = Clock::now();
  ImplicitEulerStep euler(world_, detection_.contacts(), step_s);
  Eigen::VectorXd velocities = euler.initial_guess();
  const auto prepared = Clock::now();
  report.solve = solver_.solve(euler, velocities);
  Eigen::VectorXd residual(euler.size());
  euler.residual(velocities, residual);  // the state of the best iterate
  euler.commit(world_);
  report.contacts = euler.touching();
  report.detect = detected - start;
  report.respond = prepared - detected;
  report.integrate = Clock::now() - prepared;
  return report;
}

std::vector<ToolSphereMotion> Simulation::place_tool(const ToolSample& sample) {
  std::vector<ToolSphereMotion> spheres;
  std::vector<Eigen::Vector3d> centres_m;
  for (const ToolSphere& sphere : tool_)
    centres_m.emplace_back(sample.position_m + sample.orientation * sphere.position_m);
  const bool known = tool_before_m_.size() == centres_m.size();
  for (std::size_t i = 0; i < tool_.size(); ++i)
    spheres.push_back({centres_m[i], sample.velocity_m_s, known ? tool_before_m_[i] : centres_m[i],
                       tool_[i].radius_m});
  tool_before_m_ = std::move(centres_m);
  return spheres;
}

}  // namespace stillgrid
