// A step of the engine that both processes run.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sim_server/dynamics/step/simulation.hpp"

namespace stillgrid::dynamics {
namespace {

int ticks_of(double step_s) {
  constexpr double kRounding = 1e-9;  // of a step that is a multiple of a tick
  return std::max(1, static_cast<int>(std::ceil(step_s / kTick_s - kRounding)));
}

}  // namespace

/// Of the hands that are here.
std::vector<std::optional<ToolPose>> Simulation::tool_poses() const {
  std::vector<std::optional<ToolPose>> poses(tools_.size());
  for (std::size_t hand = 0; hand < tools_.size(); ++hand) {
    if (!tools_[hand].is_here()) continue;
    const ToolSample& sample = tools_[hand].sample();
    poses[hand] = {sample.position_m, sample.orientation, sample.velocity_m_s};
  }
  return poses;
}

/// Advances the engine by the ticks of a step, until the budget is spent.
TickedWorld::Report Simulation::run_ticks(Step& step) {
  StepReport& report = step.report;
  // Substeps that are given divide the step as they are asked for, a tick each.
  const int ticks = method_.substeps > 0 ? method_.substeps : ticks_of(step.length_s);
  const double tick_s = step.length_s / ticks;
  TickedWorld::Report sum{.all_slept = true};
  for (int tick = 0; tick < ticks && !step.budget.is_stopped() && !report.out_of_budget; ++tick) {
    if (tick > 0) {
      const ToolSamples samples = later_samples(step);
      redirect(samples, tick / static_cast<double>(ticks));
      report.note_times(samples);
    }
    const auto poses = tool_poses();
    const TickedWorld::Report ticked = ticked_->advance(
        world_, {tick_s, (ticks - tick) * tick_s, method_.substeps > 0 ? 1 : 0, poses});
    sum.flow += ticked.flow;
    sum.all_slept = sum.all_slept && ticked.all_slept;
    sum.sleep_loss_J += ticked.sleep_loss_J;
    sum.substeps += ticked.substeps;
    sum.touching = ticked.touching;
    report.out_of_budget = step.budget.is_late();  // time runs late then
  }
  return sum;
}

StepReport Simulation::step_in_ticks(Step& step) {
  const auto start = std::chrono::steady_clock::now();
  StepReport& report = step.report;
  place_tools(step);
  if (is_world_changed_) ticked_->read_from(world_);
  if (watch_ && watch_->is_due(world_)) watch_->judge(world_, energies_now());
  const TickedWorld::Report ticked = run_ticks(step);
  report.stopped = step.budget.is_stopped();
  is_world_changed_ = report.stopped;  // the engine goes back to it
  if (report.stopped) return report;
  if (ticked.all_slept && !has_driven_)
    ticked_->write_time(world_);
  else if (!ticked_->write_to(world_))
    throw std::domain_error("after " + std::to_string(world_.time_s) +
                            " s of simulated time a position or a velocity is not finite: the step "
                            "is too long for the scene's stiffness, dampers and masses");
  note_ticks(ticked, report);
  report.integrate = std::chrono::steady_clock::now() - start;
  show_ticks(ticked);
  return report;
}

void Simulation::note_ticks(const TickedWorld::Report& ticked, StepReport& report) {
  tool_work_J_ += ticked.flow.tool_J;
  if (account_) account_->flow += ticked.flow;
  if (account_) account_->sleep_loss_J += ticked.sleep_loss_J;
  if (watch_) watch_->note_given(ticked.flow.given_J);
  report.note_work(tool_work_J_);
  report.contacts = ticked.touching;
  report.solve.iterations = report.substeps = ticked.substeps;
  if (ticked_->write_sleep(world_)) note_sleep();
  report.sleeping_spheres = ticked_->sleeping_spheres();
}

void Simulation::show_ticks(const TickedWorld::Report& ticked) {
  constexpr int kEnough = proto::kHistoryLength;
  still_steps_ = ticked.all_slept && !has_driven_ ? std::min(still_steps_ + 1, kEnough) : 0;
  if (still_steps_ == kEnough) return;  // every snapshot of the history shows the same
  detection_.move_spheres(world_);
  snapshot_.show(detection_);
  moving_fields_.show(world_);
}

}  // namespace stillgrid::dynamics
