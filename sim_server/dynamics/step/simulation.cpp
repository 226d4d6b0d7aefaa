#include "sim_server/dynamics/step/simulation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <utility>

#include "shared/dynamics/implicit_step.hpp"
#include "shared/realtime/flush_denormals.hpp"
#include "sim_server/dynamics/integrators/cvode_step.hpp"
#include "sim_server/scene/build_world.hpp"

namespace stillgrid::dynamics {
namespace {

EngineMethod engine_method(const scene::Method& method) {
  if (method.integrator.method != nullptr) return method.integrator.method(method.tolerance_m_s);
  if (scene::is_explicit(method.integrator)) return {};
  return scene::chooses_steps(method.integrator) ? by_cvode(method.tolerance_m_s)
                                                 : implicit_euler(method.tolerance_m_s);
}

/// Substeps that are given divide the step as they are asked for, a tick each. A step of the whole
/// scene at once is one tick else, unless a body swings: in a tick it moves evenly.
int ticks_of(double step_s, const scene::Method& method, bool swings) {
  if (method.substeps > 0) return method.substeps;
  if (!scene::is_explicit(method.integrator) && !swings) return 1;
  return dynamics::ticks_of(step_s);
}

/// A method that is chosen for its error is not continued by another one.
void require_within_work(const SolveFigures& solve, double time_s, double tick_s) {
  if (solve.converged || !solve.is_spent()) return;
  std::array<char, 300> line{};
  std::snprintf(
      line.data(), line.size(),
      "after %.6g s of simulated time cvode_bdf takes more than %ld steps and products in "
      "a tick of %.4g ms: expected a larger tolerance_m_s, slower bodies, softer springs "
      "and contacts, or another integrator",
      time_s, kMaxWork, 1e3 * tick_s);
  throw std::domain_error(line.data());
}

}  // namespace

void StepReport::note_work(const EnergyByHand_J& work_J) {
  for (std::size_t hand = 0; hand < work_J.size(); ++hand) tools[hand].work_J = work_J[hand];
}

void StepReport::note_times(std::span<const std::optional<ToolSample>> samples) {
  for (std::size_t hand = 0; hand < samples.size(); ++hand)
    if (samples[hand]) tools[hand].time_ns = samples[hand]->time_ns;
}

bool Simulation::has_ticks() const noexcept {
  return method_.substeps == 0 && (method_.integrator == scene::IntegratorKind::kVelocityVerlet ||
                                   method_.integrator == scene::IntegratorKind::kImplicitEuler);
}

Simulation::Simulation(const scene::SceneDescription& scene)
    : Simulation(scene, scene::build_world(scene)) {}

Simulation::Simulation(const scene::SceneDescription& scene, bodies::World world)
    : world_(std::move(world)),
      snapshot_(world_, scene.voxel_ratio),
      moving_fields_(snapshot::moving_fields(world_)),
      method_(scene.method),
      ticked_(world_, scene::hands_of(scene), scene.sleeping, engine_method(method_)),
      tools_(scene::hands_of(scene).size()) {
  for (const bodies::RigidBody& body : world_.rigid_bodies) {
    if (body.free) continue;
    swings_ = swings_ || body.prescribed.swings();
    has_driven_ = has_driven_ || body.prescribed.moves();
  }
}

StepReport Simulation::step(double step_s, std::span<const TakeTool> take_tools, Budget budget,
                            const AlongPaths& paths) {
  const realtime::FlushDenormals flush;
  const auto start = std::chrono::steady_clock::now();
  Step step{.length_s = step_s, .take_tools = take_tools, .budget = budget, .paths = paths};
  StepReport& report = step.report;
  report.solve.converged = true;
  place_tools(step);
  if (is_world_changed_) ticked_.read_from(world_);
  if (watch_ && watch_->is_due(world_)) watch_->judge(world_, energies_now());
  const TickedWorld::Report ticked = run_ticks(step);
  report.stopped = step.budget.is_stopped();
  is_world_changed_ = report.stopped;  // the engine goes back to it
  if (report.stopped) return report;
  if (ticked.all_slept && !has_driven_)
    ticked_.write_time(world_);
  else if (!std::isfinite(ticked.solve.residual_m_s) || !ticked_.write_to(world_))
    throw std::domain_error("after " + std::to_string(world_.time_s) +
                            " s of simulated time a position or a velocity is not finite: the step "
                            "is too long for the scene's stiffness, dampers and masses");
  note_ticks(ticked, report);
  report.integrate = std::chrono::steady_clock::now() - start;
  show_ticks(ticked);
  return report;
}

void Simulation::place_tools(Step& step) {
  for (std::size_t hand = 0; hand < tools_.size(); ++hand) {
    tools_[hand] = hand < step.take_tools.size() ? step.take_tools[hand]() : std::nullopt;
    if (tools_[hand]) step.report.tools[hand].time_ns = tools_[hand]->time_ns;
  }
}

/// None if nothing is newer than what the step has taken, or the tool has gone: that the next one
/// sees.
Simulation::ToolSamples Simulation::later_samples(const Step& step) const {
  ToolSamples samples;
  for (std::size_t hand = 0; hand < tools_.size(); ++hand) {
    if (!tools_[hand]) continue;
    samples[hand] = step.take_tools[hand]();
    if (samples[hand] && samples[hand]->time_ns <= step.report.tools[hand].time_ns)
      samples[hand].reset();
  }
  return samples;
}

void Simulation::redirect(const ToolSamples& samples) {
  for (std::size_t hand = 0; hand < tools_.size(); ++hand)
    if (samples[hand]) tools_[hand] = samples[hand];
}

/// Of the hands that are here.
std::vector<std::optional<ToolPose>> Simulation::tool_poses() const {
  std::vector<std::optional<ToolPose>> poses(tools_.size());
  for (std::size_t hand = 0; hand < tools_.size(); ++hand) {
    if (!tools_[hand]) continue;
    const ToolSample& sample = *tools_[hand];
    poses[hand] = {sample.position_m, sample.orientation, sample.velocity_m_s};
  }
  return poses;
}

/// Where tools go in a tick: to where their paths say, or on to their newest samples.
std::vector<std::optional<ToolPose>> Simulation::aim_tick(Step& step, int tick) {
  if (!step.paths.tools.empty()) {
    std::vector<std::optional<ToolPose>> poses;
    for (const ToolAt& tool : step.paths.tools)
      poses.push_back(tool(step.paths.number + 1 + static_cast<std::uint64_t>(tick)));
    return poses;
  }
  if (tick > 0) {
    const ToolSamples samples = later_samples(step);
    redirect(samples);
    step.report.note_times(samples);
  }
  return tool_poses();
}

/// Advances the engine by the ticks of a step, until the budget is spent.
TickedWorld::Report Simulation::run_ticks(Step& step) {
  StepReport& report = step.report;
  const bool follows = !step.paths.tools.empty();
  const int ticks =
      follows ? dynamics::ticks_of(step.length_s) : ticks_of(step.length_s, method_, swings_);
  const double tick_s = follows ? kTick_s : step.length_s / ticks;
  TickedWorld::Report sum{.all_slept = true};
  ticked_.stop_at(step.budget.stop);
  for (int tick = 0; tick < ticks && !step.budget.is_stopped() && !report.out_of_budget; ++tick) {
    const auto poses = aim_tick(step, tick);
    const double left_s = follows ? tick_s : (ticks - tick) * tick_s;
    const TickedWorld::Report ticked =
        ticked_.advance({tick_s, left_s, method_.substeps > 0 ? 1 : 0, poses});
    if (scene::chooses_steps(method_.integrator) && !step.budget.is_stopped())
      require_within_work(ticked.solve, world_.time_s + tick * tick_s, tick_s);
    sum.flow += ticked.flow;
    sum.all_slept = sum.all_slept && ticked.all_slept;
    sum.sleep_loss_J += ticked.sleep_loss_J;
    sum.substeps += ticked.substeps;
    sum.touching = ticked.touching;
    sum.solve += ticked.solve;
    report.last_counted_ns = ticked.counted_ns;
    ++report.ticks;
    report.out_of_budget = step.budget.is_late();  // time runs late then
  }
  return sum;
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
  if (ticked_.write_sleep(world_)) still_steps_ = 0;
  report.sleeping_spheres = ticked_.sleeping_spheres();
}

void Simulation::show_ticks(const TickedWorld::Report& ticked) {
  constexpr int kEnough = proto::kHistoryLength;
  still_steps_ = ticked.all_slept && !has_driven_ ? std::min(still_steps_ + 1, kEnough) : 0;
  if (still_steps_ == kEnough) return;  // every snapshot of the history shows the same
  snapshot_.show(world_);
  snapshot::show(world_, moving_fields_);
}

std::uint64_t Simulation::save_state(std::vector<std::byte>& state) const {
  ticked_.save(state);
  return hash(ticked_.engine().state());
}

std::vector<std::byte> Simulation::contact_state() const {
  std::vector<std::byte> state;
  ticked_.engine().save(state);
  return state;
}

void Simulation::set_contact_state(std::span<const std::byte> state) {
  if (!state.empty()) ticked_.load(state);
}

void Simulation::account_energy() {
  ticked_.count_losses();
  account_.emplace().start = energies_now();
}

void Simulation::watch_energy() {
  watch_.emplace(energies_now());
}

void Simulation::judge_energy() {
  if (watch_) watch_->judge(world_, energies_now());
}

std::optional<EnergyAccount> Simulation::energy_account() {
  if (account_) account_->end = energies_now();
  return account_;
}

Energies Simulation::energies_now() const {
  Energies now = energies_without_contacts(world_);
  now.contacts_J = ticked_.engine().contact_energy_J();
  return now;
}

}  // namespace stillgrid::dynamics
