#include "sim_server/dynamics/step/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "shared/realtime/flush_denormals.hpp"
#include "sim_server/bodies/rotation.hpp"
#include "sim_server/contact/crossing.hpp"
#include "sim_server/scene/build_world.hpp"

namespace stillgrid::dynamics {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kMaxSubsteps = 8;                   // of a step that does not converge
constexpr double kShortest = 1.5 / kMaxSubsteps;  // of a step: it is not halved again
constexpr int kIterations = 15;                   // of a part that may be halved
constexpr int kLastIterations = 200;              // of one that may not
constexpr int kMaxShortenings = 64;               // of a step in which spheres cross
constexpr int kMaxWidenings = 3;                  // of the ways of a part
constexpr double kShortestHalf = 1e-3;            // of a step, below which no memory is spared
constexpr double kLeastShare = 1e-6;              // of a step, so that every part moves it on

/// Steps in which nothing moved, until no snapshot of the history shows a motion.
constexpr int kStillSteps = proto::kHistoryLength;

/// The last iteration of a step that is out of time has a tenth of the step, and no more.
Budget last_iteration(Budget budget, double step_s) {
  budget.iterations = 1;
  if (budget.has_deadline())
    budget.deadline_ns =
        std::max(budget.deadline_ns, budget.now_ns()) + realtime::to_ns(0.1 * step_s);
  return budget;
}

EngineMethod engine_method(const scene::Method& method) {
  if (scene::is_explicit(method.integrator)) return {};
  return {.kind = Method::kImplicitEuler, .tolerance_m_s = method.tolerance_m_s};
}

void require_finite(const Trial& trial, double time_s) {
  if (trial.is_finite) return;
  throw std::domain_error("after " + std::to_string(time_s) +
                          " s of simulated time a position or a velocity is not finite: the step "
                          "is too long for the scene's stiffness, dampers and masses");
}

}  // namespace

void StepReport::note_work(const EnergyByHand_J& work_J) {
  for (std::size_t hand = 0; hand < work_J.size(); ++hand) tools[hand].work_J = work_J[hand];
}

void StepReport::note_times(std::span<const std::optional<ToolSample>> samples) {
  for (std::size_t hand = 0; hand < samples.size(); ++hand)
    if (samples[hand]) tools[hand].time_ns = samples[hand]->time_ns;
}

Simulation::Simulation(const scene::SceneDescription& scene)
    : Simulation(scene, scene::build_world(scene)) {}

Simulation::Simulation(const scene::SceneDescription& scene, bodies::World world)
    : world_(std::move(world)),
      detection_(world_, scene.voxel_ratio),
      snapshot_(world_, detection_),
      moving_fields_(world_),
      method_(scene.method),
      prediction_(std::make_unique<Prediction>(scene::is_explicit(method_.integrator))),
      start_(world_.spheres.size()),
      end_(world_.spheres.size()) {
  for (const scene::Hand& hand : scene::hands_of(scene)) tools_.emplace_back(hand, tools_.size());
  if (scene::is_by_engine(method_.integrator)) {
    ticked_.emplace(world_, scene::hands_of(scene), scene.sleeping, engine_method(method_));
  } else {
    integrator_ = make_integrator(method_);
    traits_ = integrator_->traits();
    if (scene.sleeping) sleeping_.emplace(world_);
  }
  for (const bodies::RigidBody& body : world_.rigid_bodies) {
    if (body.free) continue;
    swings_ = swings_ || bodies::swings(body);
    has_driven_ = has_driven_ || bodies::is_moved(body);
  }
}

StepReport Simulation::step(double step_s, std::span<const TakeTool> take_tools, Budget budget) {
  const realtime::FlushDenormals flush;
  Step step{.length_s = step_s, .take_tools = take_tools, .budget = budget};
  StepReport& report = step.report;
  report.solve.converged = true;
  if (ticked_) return step_in_ticks(step);
  // Halving is exact; a part that ends before a crossing may have any length.
  double longest = 1.0 / std::max({1, method_.substeps, substeps_ / 2});
  Part part{.end = longest};
  const auto start = Clock::now();
  const bool may_pass = still_steps_ >= kStillSteps;
  if (!may_pass) find_contacts(step_s, part);
  place_tools(step);
  find_tool_contacts(part);
  passes_ = may_pass && detection_.contacts().empty();
  if (passes_) return pass(step_s, report);
  if (may_pass) {  // the tool comes near
    find_contacts(step_s, part);
    find_tool_contacts(part);
  }
  predicted_s_ = 0.0;
  report.detect += Clock::now() - start;
  if (watch_) watch_->look(world_, detection_.contacts());

  int shortenings = 0;
  while (true) {
    part.must_advance = part.must_end || part.end - part.start <= kShortest;
    part.may_shorten = shortenings < kMaxShortenings && !part.must_end;
    const Attempt attempt = advance(part, step);
    if (step.budget.is_stopped() && !(attempt.advanced && part.end >= 1.0)) {
      report.stopped = true;
      return report;
    }
    if (attempt.again) continue;
    if (attempt.advanced) {
      if (part.end >= 1.0) break;
      part.start = part.end;
      part.end = std::min(1.0, part.start + longest);
      if (1.0 - part.end < kLeastShare) part.end = 1.0;
    } else if (attempt.share < 1.0) {
      ++shortenings;
      part.end = part.start + std::max(kLeastShare, attempt.share * (part.end - part.start));
    } else if (!attempt.woke) {
      longest = halved_below(longest, part.end - part.start);
      part.end = part.start + longest;
    }
    part.widened = 0;
    part.must_end = step.budget.spent();
    if (part.must_end) part.end = 1.0;
    const auto again = Clock::now();
    find_contacts(step_s, part);
    const ToolSamples samples = later_samples(step);
    redirect(samples, part.start);
    report.note_times(samples);
    find_tool_contacts(part);
    report.detect += Clock::now() - again;
  }
  substeps_ = static_cast<int>(1.0 / longest);
  report.note_work(tool_work_J_);
  if (sleeping_) {
    const bool is_sure = report.solve.converged && !report.out_of_budget;
    if (const auto sleep_loss_J = sleeping_->settle(
            world_, detection_.contacts(), integrator_->trial().spheres, step_s, is_sure)) {
      if (account_) account_->sleep_loss_J += *sleep_loss_J;
      note_sleep();
    }
    report.sleeping_spheres = sleeping_->sleeping_spheres();
  }
  detection_.move_spheres(world_);
  snapshot_.show(detection_);
  moving_fields_.show(world_);
  const bool is_still = world_.unknown_count == 0 && !has_driven_;
  still_steps_ = is_still && report.contacts == 0 ? std::min(still_steps_ + 1, kStillSteps) : 0;
  return report;
}

/// A step in which nothing can move, and nothing did in any snapshot of the history: time passes.
StepReport Simulation::pass(double step_s, StepReport& report) {
  world_.time_s += step_s;
  report.substeps = 1;
  report.note_work(tool_work_J_);
  if (sleeping_) report.sleeping_spheres = sleeping_->sleeping_spheres();
  return report;
}

const std::vector<contact::ToolSphereMotion>& Simulation::tools_over(double start, double end) {
  tool_spheres_.clear();
  for (const ToolMotion& tool : tools_) tool.add_over(start, end, tool_spheres_);
  return tool_spheres_;
}

void Simulation::place_tools(Step& step) {
  for (std::size_t hand = 0; hand < tools_.size(); ++hand)
    take(hand, hand < step.take_tools.size() ? step.take_tools[hand]() : std::nullopt, step);
}

void Simulation::take(std::size_t hand, const std::optional<ToolSample>& sample, Step& step) {
  // A tool that comes or goes while it overlaps something brings or takes what their contact holds:
  // where it is at the start of its first step, or was at the end of its last.
  ToolMotion& tool = tools_[hand];
  const auto held_J = [&](double share) {
    tool_spheres_.clear();
    tool.add_over(share, share, tool_spheres_);
    detection_.find_tool_contacts(world_, tool_spheres_);
    return tool_energy_J(detection_.contacts());
  };
  const bool was_here = tool.is_here(), must_count = !ticked_;  // the engine does
  double brought_J = must_count && was_here && !sample ? -held_J(1.0) : 0.0;
  if (sample) {
    step.report.tools[hand].time_ns = sample->time_ns;
    tool.place(*sample, step.length_s);
  } else {
    tool.remove();
  }
  if (must_count && !was_here && sample) brought_J = held_J(0.0);
  tool_work_J_[hand] += brought_J;
  if (account_) account_->flow.given_J += brought_J;
  if (watch_) watch_->note_given(brought_J);
}

/// None if nothing is newer than what the step has taken, or the tool has gone: that the next one
/// sees.
Simulation::ToolSamples Simulation::later_samples(const Step& step) const {
  ToolSamples samples;
  for (std::size_t hand = 0; hand < tools_.size(); ++hand) {
    if (!tools_[hand].is_here()) continue;
    samples[hand] = step.take_tools[hand]();
    if (samples[hand] && samples[hand]->time_ns <= step.report.tools[hand].time_ns)
      samples[hand].reset();
  }
  return samples;
}

void Simulation::redirect(const ToolSamples& samples, double from) {
  for (std::size_t hand = 0; hand < tools_.size(); ++hand)
    if (samples[hand]) tools_[hand].redirect(*samples[hand], from);
}

/// Halves the part as often as that spares memory, within reason.
void Simulation::find_contacts(double step_s, Part& part) {
  const auto length = [&] { return part.end - part.start; };
  while (!detection_.find_contacts(world_, step_s * length(), length() < kShortestHalf))
    part.end = part.start + 0.5 * length();
}

void Simulation::find_tool_contacts(const Part& part) {
  detection_.find_tool_contacts(world_, tools_over(part.start, part.end));
}

/// One step of the integrator. Leaves the world as it was if it did not converge and need not
/// advance, if spheres crossed and it may be shortened, or if someone woke.
Simulation::Attempt Simulation::advance(Part& part, Step& step) {
  const auto start = Clock::now();
  StepReport& report = step.report;
  Budget& budget = step.budget;
  const double duration_s = step.length_s * (part.end - part.start);
  take_prediction(duration_s);
  const contact::Ways predicted = ways_to(end_, end_bodies_, duration_s);
  if (wake_touched(predicted)) return {.woke = true};
  if (part.may_shorten) {
    const double share = contact::share_before_crossings(detection_.contacts(), predicted);
    if (share < 1.0) return {.share = share};
  }
  // What must end has one iteration, however late it is.
  Budget own = budget;
  int most = part.must_advance ? kLastIterations : kIterations;
  if (traits_.most_iterations > 0) most = traits_.most_iterations;
  own.iterations = std::min(most, budget.iterations);
  if (part.must_end) own = last_iteration(budget, step.length_s);
  const auto prepared = Clock::now();
  SolveReport solve = integrator_->advance(world_, detection_.contacts(), duration_s, own);
  report.respond += prepared - start;
  report.solve.iterations += solve.iterations;
  report.solve.products += solve.products;
  if (traits_.solves) budget.iterations -= solve.iterations;
  report.integrate += Clock::now() - prepared;
  if (budget.is_stopped() || (!solve.converged && !part.must_advance)) return {};
  require_finite(integrator_->trial(), world_.time_s);

  // Forces may have led elsewhere than the velocities before them.
  const Trial& trial = integrator_->trial();
  const contact::Ways ways = ways_to(trial.spheres, trial.rigid_bodies, duration_s);
  if (wake_touched(ways)) return {.woke = true};
  // Before strays have the contacts listed anew.
  const EnergyFlow flowed = flow_of(part, duration_s);
  const Strays strays = look_for_strays(part, duration_s);
  if (strays != Strays::kNone) return {.again = strays == Strays::kAgain};
  const double reached = contact::share_before_crossings(detection_.contacts(), ways);
  if (reached < 1.0 && part.may_shorten) return {.share = reached};
  if (account_) account_->flow += flowed;
  if (watch_) watch_->note_given(flowed.given_J);
  tool_work_J_ += flowed.tool_J;
  integrator_->commit(world_, duration_s);
  report.out_of_budget = report.out_of_budget || part.must_end;
  ++report.substeps;
  report.crossings_left += reached < 1.0 ? 1 : 0;
  report.contacts = trial.touching;
  report.solve.converged = report.solve.converged && solve.converged;
  // The worst of all substeps, and what is no number is the worst.
  double& worst = report.solve.residual;
  if (!std::isnan(worst) && !(solve.residual <= worst)) worst = solve.residual;
  return {.advanced = true};
}

/// Over the integrator's last step; what the tool gives always, the rest where it is accounted for.
EnergyFlow Simulation::flow_of(const Part& part, double duration_s) {
  const Trial& trial = integrator_->trial();
  EnergyFlow flow;
  if (account_ || watch_)
    flow = energy_flow(world_, trial, detection_.contacts(), duration_s);
  else
    flow.tool_J = tool_flow_J(world_, trial, detection_.contacts(), duration_s);
  if (has_driven_) {
    detection_.find_led_contacts(world_, tools_over(part.start, part.end), led_contacts_);
    flow.tool_J += led_flow_J(world_, trial, led_contacts_, duration_s);
  }
  return flow;
}

/// Whether what forces led off its way met what is on no list, and what is to be done about it.
Simulation::Strays Simulation::look_for_strays(Part& part, double duration_s) {
  const Trial& trial = integrator_->trial();
  const std::vector<bodies::SphereMotion>& end = trial.spheres;
  if (part.must_end || part.widened == kMaxWidenings ||
      !detection_.strayed(world_, end, trial.rigid_bodies))
    return Strays::kNone;
  const double length = part.end - part.start;
  if (!detection_.widen(world_, end, trial.rigid_bodies, length < kShortestHalf))
    return Strays::kShorter;
  find_tool_contacts(part);
  if (!detection_.has_missed(world_, ways_to(end, trial.rigid_bodies, duration_s)))
    return Strays::kNone;
  ++part.widened;
  return Strays::kAgain;
}

/// Where every sphere is, and where its velocity leads, or the law of its motion.
void Simulation::take_prediction(double duration_s) {
  take_bodies(duration_s);
  for (const bodies::BodyRange& body : world_.bodies) {
    if (body.is_sleeping) continue;  // where note_sleep() saw it
    for (int sphere = body.first_sphere; sphere < body.first_sphere + body.sphere_count; ++sphere) {
      const auto i = static_cast<std::size_t>(sphere);
      start_[i] = detection_.motions()[i];
      end_[i].position_m = start_[i].position_m + duration_s * start_[i].velocity_m_s;
    }
    if (!swings_ || body.rigid < 0) continue;
    const bodies::RigidBody& rigid = world_.rigid_bodies[static_cast<std::size_t>(body.rigid)];
    if (rigid.free) continue;
    const Eigen::Vector3d move_m =
        bodies::prescribed_state(rigid, world_.time_s + duration_s).position_m - rigid.position_m;
    for (int i = body.first_sphere; i < body.first_sphere + body.sphere_count; ++i)
      end_[static_cast<std::size_t>(i)].position_m =
          start_[static_cast<std::size_t>(i)].position_m + move_m;
  }
}

/// Where bodies with fields would be then.
void Simulation::take_bodies(double duration_s) {
  if (world_.fields.empty()) return;
  end_bodies_ = world_.rigid_bodies;
  for (const bodies::FieldBody& field : world_.fields) {
    if (field.rigid < 0) continue;
    bodies::RigidBody& body = end_bodies_[static_cast<std::size_t>(field.rigid)];
    if (world_.bodies[static_cast<std::size_t>(field.body)].is_sleeping) continue;
    if (!body.free) {
      body.position_m = bodies::prescribed_state(body, world_.time_s + duration_s).position_m;
      continue;
    }
    body.position_m += duration_s * body.velocity_m_s;
    body.orientation =
        (bodies::rotation_of(duration_s * body.angular_velocity_rad_s) * body.orientation)
            .normalized();
  }
}

contact::Ways Simulation::ways_to(std::span<const bodies::SphereMotion> end,
                                  std::span<const bodies::RigidBody> end_bodies,
                                  double duration_s) const {
  return {start_, end, swings_ || !world_.fields.empty() ? &world_ : nullptr, duration_s,
          end_bodies};
}

bool Simulation::wake_touched(const contact::Ways& ways) {
  if (!sleeping_ || !sleeping_->wake_touched(world_, detection_.contacts(), ways)) return false;
  note_sleep();
  return true;
}

void Simulation::note_sleep() {
  still_steps_ = 0;
  if (integrator_) integrator_->restart();
  detection_.note_sleep(world_);
  for (std::size_t i = 0; i < world_.spheres.size(); ++i)
    start_[i] = end_[i] = bodies::sphere_motion(world_, world_.spheres[i]);
}

publication::SnapshotPrediction Simulation::predict_next(double step_s, const Budget& budget,
                                                         std::size_t hand) {
  const bool is_alone = tools_.size() == 1;
  prediction_work_ = {};
  if (!is_alone) {
    snapshot_.forget_predictions(detection_.spheres());
    moving_fields_.forget_predictions();
  }
  if (budget.is_late()) return {};
  // Nothing moved since the last one.
  if (passes_ && predicted_s_ == step_s) return prediction_->snapshot();

  tool_spheres_.clear();
  for (std::size_t other = 0; other < tools_.size(); ++other)
    if (other != hand) tools_[other].add_over(1.0, 1.0, tool_spheres_);
  const std::size_t of_others = tool_spheres_.size();
  tools_[hand].add_over(1.0, 1.0, tool_spheres_);
  const auto tool = std::span(std::as_const(tool_spheres_)).subspan(of_others);
  if (tool.empty() && world_.spheres.size() > PredictedPart::kMaxSpheres) return {};
  predicted_part_.choose(world_, detection_.motions(), tool);
  // What may touch by then, on lists of its own: those of the next step stay in their order.
  if (!predicted_contacts_.find(world_, detection_, predicted_part_.spheres(), step_s,
                                tool_spheres_))
    return {};
  // Of a part they are known by other numbers.
  std::vector<ContactMemory> kept;
  if (predicted_part_.is_whole()) kept = stretched_contacts();
  prediction_->look(predicted_part_.world(),
                    predicted_part_.renumbered(predicted_contacts_.contacts()), step_s, kept,
                    budget, hand);
  prediction_work_ = prediction_->work();
  for (proto::TurningBody& turning : prediction_->turning())
    turning.body = predicted_part_.scene_body(turning.body);
  snapshot_.take_predictions(predicted_part_.spheres(), prediction_->spheres(),
                             proto::kPredictionPeriods * step_s, proto::kLongestPredictionLag_s,
                             detection_.spheres());
  moving_fields_.take_predictions(prediction_->fields(), [&](std::size_t field) {
    return predicted_part_.world().fields[field].rigid >= 0;
  });
  if (passes_ && is_alone) predicted_s_ = step_s;
  return prediction_->snapshot();
}

void Simulation::account_energy() {
  if (ticked_) ticked_->count_losses();
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

Energies Simulation::energies_now() {
  if (ticked_) {
    Energies now = energies_without_contacts(world_);
    now.contacts_J = ticked_->engine().contact_energy_J();
    return now;
  }
  Energies now = energies(world_, tools_over(1.0, 1.0));
  if (const ContactMemories* memories = this->memories()) now.contacts_J += memories->energy_J();
  return now;
}

}  // namespace stillgrid::dynamics
