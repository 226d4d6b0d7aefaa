// A step of the engine that both processes run.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sim_server/dynamics/step/simulation.hpp"

namespace stillgrid::dynamics {
namespace {

/// Substeps that are given divide the step as they are asked for, a tick each. An implicit step is
/// one tick else, unless a body swings: in a tick it moves evenly.
int ticks_of(double step_s, const scene::Method& method, bool swings) {
  if (method.substeps > 0) return method.substeps;
  if (scene::is_implicit(method.integrator) && !swings) return 1;
  return dynamics::ticks_of(step_s);
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
  const int ticks = ticks_of(step.length_s, method_, swings_);
  const double tick_s = step.length_s / ticks;
  TickedWorld::Report sum{.all_slept = true};
  ticked_->stop_at(step.budget.stop);
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
    sum.solve += ticked.solve;
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
  else if (!std::isfinite(ticked.solve.residual_m_s) || !ticked_->write_to(world_))
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
  report.substeps = ticked.substeps;
  report.crossings_left = ticked.solve.passes;
  report.solve = {.converged = ticked.solve.converged,
                  .iterations = ticked.solve.iterations,
                  .products = ticked.solve.products,
                  .residual = ticked.solve.residual_m_s};
  if (scene::is_explicit(method_.integrator)) report.solve.iterations = ticked.substeps;
  if (ticked_->write_sleep(world_)) note_sleep();
  report.sleeping_spheres = ticked_->sleeping_spheres();
}

std::vector<std::byte> Simulation::contact_state() const {
  std::vector<std::byte> state;
  if (ticked_) ticked_->engine().save(state);
  return state;
}

void Simulation::set_contact_state(std::span<const std::byte> state) {
  if (ticked_ && !state.empty()) ticked_->load(state);
}

/// Contacts that friction has stretched, by key.
std::vector<ContactMemory> Simulation::stretched_contacts() const {
  if (!ticked_) return memories() != nullptr ? memories()->kept() : std::vector<ContactMemory>();
  std::vector<ContactMemory> stretched;
  const auto spheres = static_cast<std::int32_t>(world_.spheres.size());
  const auto set_other = [&](std::int32_t sphere, contact::Contact& pair) {
    (sphere < spheres ? pair.b : pair.other) = sphere < spheres ? sphere : sphere - spheres;
  };
  for (const ContactListing::Stretched& listed : ticked_->engine().listing().stretched()) {
    contact::Contact pair;
    pair.a = listed.sphere_a;
    pair.other = listed.plane;
    pair.is_plane = listed.plane >= 0;
    Eigen::Vector3d stretch_m = listed.stretch_m;
    if (listed.field >= 0) {
      pair.b = spheres + listed.field;
    } else if (listed.sphere_a >= spheres) {  // a fixture
      stretch_m = -stretch_m;
      pair.a = listed.sphere_b;
      set_other(listed.sphere_a, pair);
    } else if (listed.plane < 0) {
      set_other(listed.sphere_b, pair);
    }
    if (is_turned(pair)) stretch_m = -stretch_m;
    stretched.push_back({.key = key_of(pair),
                         .stiffness_N_per_m = listed.stiffness_N_per_m,
                         .stretch_m = stretch_m});
  }
  std::ranges::sort(stretched, {}, &ContactMemory::key);
  return stretched;
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
