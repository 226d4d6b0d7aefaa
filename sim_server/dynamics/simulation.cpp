#include "sim_server/dynamics/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "sim_server/contact/crossing.hpp"

namespace stillgrid {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kMostSubsteps = 8;                   // of a step that does not converge
constexpr double kShortest = 1.5 / kMostSubsteps;  // of a step: it is not halved again
constexpr int kIterations = 15;                    // of a part that may be halved
constexpr int kLastIterations = 200;               // of one that may not
constexpr int kMostShortenings = 64;               // of a step in which spheres cross
constexpr double kLeastShare = 1e-6;               // of a step, so that every part moves it on

/// Explicit integrators divide their steps themselves.
int parts_asked(const Method& method) {
  return is_explicit(method.integrator) ? 1 : method.substeps;
}

}  // namespace

Simulation::Simulation(const SceneDescription& scene)
    : world_(build_world(scene)),
      detection_(world_, scene.voxel_ratio),
      method_(scene.method),
      integrator_(make_integrator(method_)),
      tool_(scene.tool),
      start_(world_.spheres.size()),
      end_(world_.spheres.size()) {}

StepReport Simulation::step(double step_s,
                            const std::function<std::optional<ToolSample>()>& take_tool,
                            Budget budget) {
  StepReport report;
  report.solve.converged = true;
  // Halving is exact; a part that ends before a crossing may have any length.
  double longest = 1.0 / std::max({1, parts_asked(method_), substeps_ / 2});
  Part part{.end = longest};
  const auto start = Clock::now();
  detection_.find_contacts(world_, step_s * part.end);
  if (const auto sample = take_tool()) {
    report.tool_time_ns = sample->time_ns;
    place_tool(*sample);
  } else {
    placed_tool_.clear();
  }
  find_tool_contacts(part);
  report.detect += Clock::now() - start;

  int shortenings = 0;
  while (true) {
    part.must_advance =
        part.must_end || part.end - part.start <= kShortest || is_explicit(method_.integrator);
    part.may_shorten = shortenings < kMostShortenings && !part.must_end;
    const Attempt attempt = advance(part, step_s, budget, report);
    if (attempt.advanced) {
      if (part.end >= 1.0) break;
      part.start = part.end;
      part.end = std::min(1.0, part.start + longest);
      if (1.0 - part.end < kLeastShare) part.end = 1.0;
    } else if (attempt.share < 1.0) {
      ++shortenings;
      part.end = part.start + std::max(kLeastShare, attempt.share * (part.end - part.start));
    } else {
      longest = halved_below(longest, part.end - part.start);
      part.end = part.start + longest;
    }
    part.must_end = budget.spent();
    if (part.must_end) part.end = 1.0;
    const auto again = Clock::now();
    detection_.find_contacts(world_, step_s * (part.end - part.start));
    find_tool_contacts(part);
    report.detect += Clock::now() - again;
  }
  substeps_ = static_cast<int>(1.0 / longest);
  detection_.show(world_);
  return report;
}

/// One step of the integrator. Leaves the world as it was if it did not converge and need not
/// advance, or if spheres crossed and it may be shortened.
Simulation::Attempt Simulation::advance(const Part& part, double step_s, Budget& budget,
                                        StepReport& report) {
  const auto start = Clock::now();
  const double duration_s = step_s * (part.end - part.start);
  const double share = share_by_velocity(duration_s);
  if (share < 1.0 && part.may_shorten) return {false, share};
  // What must end has one iteration, however late it is.
  Budget own{.iterations = part.must_advance ? kLastIterations : kIterations,
             .deadline = budget.deadline};
  own.iterations = std::min(own.iterations, budget.iterations);
  if (part.must_end) own = {.iterations = 1};
  const auto prepared = Clock::now();
  const SolveReport solve = integrator_->advance(world_, detection_.contacts(), duration_s, own);
  report.respond += prepared - start;
  report.solve.iterations += solve.iterations;
  budget.iterations -= solve.iterations;
  report.integrate += Clock::now() - prepared;
  if (!solve.converged && !part.must_advance) return {};

  // Forces may have led elsewhere than the velocities before them.
  const double reached =
      share_before_crossings(detection_.contacts(), start_, integrator_->trial().spheres);
  if (reached < 1.0 && part.may_shorten) return {false, reached};
  integrator_->commit(world_, duration_s);
  report.out_of_budget = report.out_of_budget || part.must_end;
  ++report.substeps;
  report.crossings_left += reached < 1.0 ? 1 : 0;
  report.contacts = integrator_->trial().touching;
  report.solve.converged = report.solve.converged && solve.converged;
  // The worst of all substeps, and what is no number is the worst.
  double& worst = report.solve.residual;
  if (!std::isnan(worst) && !(solve.residual <= worst)) worst = solve.residual;
  return {true, 1.0};
}

double Simulation::share_by_velocity(double duration_s) {
  for (std::size_t i = 0; i < world_.spheres.size(); ++i) {
    start_[i] = sphere_motion(world_, world_.spheres[i]);
    end_[i].position_m = start_[i].position_m + duration_s * start_[i].velocity_m_s;
  }
  return share_before_crossings(detection_.contacts(), start_, end_);
}

/// The tool moves evenly over the step, from its last sample to this one.
void Simulation::find_tool_contacts(const Part& part) {
  tool_part_ = placed_tool_;
  for (ToolSphereMotion& sphere : tool_part_) {
    const Eigen::Vector3d from_m = sphere.position_before_m;
    const Eigen::Vector3d move_m = sphere.position_m - from_m;
    if (part.end < 1.0) sphere.position_m = from_m + part.end * move_m;
    sphere.position_before_m = from_m + part.start * move_m;
  }
  detection_.find_tool_contacts(world_, tool_part_);
}

void Simulation::place_tool(const ToolSample& sample) {
  const bool known = placed_tool_.size() == tool_.size();
  Eigen::Vector3d spin_rad_s = Eigen::Vector3d::Zero();
  if (known && sample.time_ns > last_sample_.time_ns) {
    const Eigen::AngleAxisd turn(sample.orientation * last_sample_.orientation.conjugate());
    // The shorter way round.
    const double angle_rad = std::remainder(turn.angle(), 2.0 * std::numbers::pi);
    spin_rad_s =
        angle_rad * 1e9 / static_cast<double>(sample.time_ns - last_sample_.time_ns) * turn.axis();
  }
  last_sample_ = sample;
  placed_tool_.resize(tool_.size());
  for (std::size_t i = 0; i < tool_.size(); ++i) {
    const Eigen::Vector3d centre_m = sample.position_m + sample.orientation * tool_[i].position_m;
    placed_tool_[i] = {
        centre_m, sample.velocity_m_s + spin_rad_s.cross(centre_m - sample.position_m),
        known ? placed_tool_[i].position_m : centre_m, tool_[i].radius_m, spin_rad_s};
  }
}

}  // namespace stillgrid
