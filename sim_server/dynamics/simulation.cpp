#include "sim_server/dynamics/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim_server/dynamics/implicit_euler.hpp"

namespace stillgrid {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kMostSubsteps = 8;

}  // namespace

Simulation::Simulation(const SceneDescription& scene)
    : world_(build_world(scene)), detection_(world_, scene.voxel_ratio), tool_(scene.tool) {}

StepReport Simulation::step(double step_s,
                            const std::function<std::optional<ToolSample>()>& take_tool) {
  StepReport report;
  report.solve.converged = true;
  const auto start = Clock::now();
  detection_.find_contacts(world_, step_s);
  if (const auto sample = take_tool()) {
    report.tool_time_ns = sample->time_ns;
    place_tool(*sample);
    detection_.find_tool_contacts(world_, placed_tool_);
  } else {
    placed_tool_.clear();
  }
  report.detect += Clock::now() - start;

  // Time is counted in the shortest substeps, so that halving is exact.
  int done = 0;
  int length = kMostSubsteps / std::max(1, substeps_ / 2);
  bool detected = true;
  while (done < kMostSubsteps) {
    const double substep_s = step_s * length / kMostSubsteps;
    if (!detected) {
      const auto again = Clock::now();
      detection_.find_contacts(world_, substep_s);
      detection_.find_tool_contacts(world_, placed_tool_);
      report.detect += Clock::now() - again;
    }
    if (advance(substep_s, length == 1, report)) {
      done += length;
      detected = false;
      for (ToolSphereMotion& sphere : placed_tool_) sphere.position_before_m = sphere.position_m;
    } else {
      length /= 2;  // the contacts of the longer substep hold those of the shorter
    }
  }
  substeps_ = kMostSubsteps / length;
  return report;
}

/// One implicit step. False, with the world as it was, if it did not converge and need not advance.
bool Simulation::advance(double step_s, bool must_advance, StepReport& report) {
  const auto start = Clock::now();
  ImplicitEulerStep euler(world_, detection_.contacts(), step_s);
  Eigen::VectorXd velocities = euler.initial_guess();
  const auto prepared = Clock::now();
  const SolveReport solve = (must_advance ? patient_solver_ : solver_).solve(euler, velocities);
  report.respond += prepared - start;
  report.solve.iterations += solve.iterations;
  const bool advances = solve.converged || must_advance;
  if (advances) {
    euler.commit(world_);
    ++report.substeps;
    report.contacts = euler.touching();
    report.solve.converged = report.solve.converged && solve.converged;
    // The worst of all substeps, and what is no number is the worst.
    double& worst = report.solve.residual;
    if (!std::isnan(worst) && !(solve.residual <= worst)) worst = solve.residual;
  }
  report.integrate += Clock::now() - prepared;
  return advances;
}

void Simulation::place_tool(const ToolSample& sample) {
  const bool known = placed_tool_.size() == tool_.size();
  placed_tool_.resize(tool_.size());
  for (std::size_t i = 0; i < tool_.size(); ++i) {
    const Eigen::Vector3d centre_m = sample.position_m + sample.orientation * tool_[i].position_m;
    placed_tool_[i] = {centre_m, sample.velocity_m_s, known ? placed_tool_[i].position_m : centre_m,
                       tool_[i].radius_m};
  }
}

}  // namespace stillgrid
