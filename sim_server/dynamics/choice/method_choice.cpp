#include "sim_server/dynamics/choice/method_choice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/scene/build_world.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr double kHorizon_s = 0.5;              // of the scene's time, of each trial
constexpr double kReferenceBudget_ms = 2000.0;  // by counts
constexpr double kMinSteps = 8.0, kMaxSteps = 500.0;
constexpr double kReferenceDivision = 4.0;  // of the stable step
constexpr double kMaxDivisions = 1e4;       // of a period by the explicit reference
constexpr double kContactPeriod_s = 1e-3;   // the reference detects contacts this often
constexpr double kReferenceTolerance_m_s = 1e-6;
constexpr int kHapticSteps = 200;
constexpr double kHopeless = 10.0;  // periods that a step costs: not tried to the end
constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Tell = std::function<void(const std::string&)>;
using Positions = std::vector<Eigen::Vector3d>;

Positions positions_of(const bodies::World& world) {
  Positions positions;
  for (const bodies::Node& node : world.nodes) positions.push_back(node.position_m);
  for (const bodies::RigidBody& body : world.rigid_bodies)
    if (body.free) positions.push_back(body.position_m);
  return positions;
}

double rms_distance_m(const Positions& a, const Positions& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return a.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(a.size()));
}

/// Result of running a scene by one method.
struct Run {
  Positions end;
  double step_ms = 0.0;  // by counts, the mean
  std::string failure;   // empty: it reached the end
};

/// Runs a scene by one method. Stops when its steps together have cost more than most_ms.
Run run_trial(scene::SceneDescription scene, const SceneLoad& load, const scene::Method& method,
              int steps, double most_ms) {
  scene.method = method;
  scene.sleeping = false;  // a body at rest now may move when it counts
  Run run;
  double spent_ms = 0.0;
  try {
    Simulation simulation(scene);
    for (int step = 1; step <= steps; ++step) {
      const StepReport report = simulation.step(scene.period_s, [] { return std::nullopt; });
      spent_ms += cost_ms(load, method,
                          {.parts = static_cast<double>(report.substeps),
                           .iterations = static_cast<double>(report.solve.iterations),
                           .products = static_cast<double>(report.solve.products),
                           .contacts = static_cast<double>(report.contacts)});
      run.step_ms = spent_ms / step;
      if (!report.solve.converged) run.failure = "did not converge";
      if (spent_ms > most_ms) run.failure = "stopped: costs too much";
      if (!run.failure.empty()) return run;
    }
    run.end = positions_of(simulation.world());
  } catch (const std::domain_error&) {
    run.failure = "unstable";
  } catch (const std::runtime_error& error) {  // a build without SUNDIALS
    run.failure = error.what();
  }
  return run;
}

scene::Method verlet(int substeps) {
  return {.integrator = scene::IntegratorKind::kVelocityVerlet, .substeps = substeps};
}

/// A tenth of the target if each step of the trial errs the same way.
double tolerance_m_s(const scene::SceneDescription& scene) {
  return std::clamp(0.1 * scene.error_target_m / kHorizon_s, 1e-8, 1e-3);
}

/// The methods to try. Within implicit_euler each costs more than the one before.
std::vector<scene::Method> candidates(const scene::SceneDescription& scene) {
  std::vector<scene::Method> methods = {verlet(0)};
  for (const int substeps : {1, 2, 4})
    methods.push_back({.substeps = substeps, .tolerance_m_s = tolerance_m_s(scene)});
  return methods;
}

/// Substeps of a period by which the explicit method errs little.
double divisions_of(const SceneLoad& load, double period_s) {
  return std::ceil(kReferenceDivision * period_s / stable_step_s(load));
}

/// Steps of a trial: fewer where the reference is expensive.
int steps_of(const SceneLoad& load, double period_s) {
  const double divisions = std::clamp(divisions_of(load, period_s), 1.0, kMaxDivisions);
  const double reference_ms = cost_ms(load, verlet(0), {.iterations = divisions});
  return static_cast<int>(std::clamp(
      std::min(kHorizon_s / period_s, kReferenceBudget_ms / reference_ms), kMinSteps, kMaxSteps));
}

/// Runs the reference, and again with twice its step or ten times its tolerance: the distance is
/// the floor. Returns the positions that it ends with; empty: none.
Positions run_reference(scene::SceneDescription scene, int steps, const Tell& tell,
                        MethodChoice& choice) {
  const double divisions = divisions_of(choice.load, scene.period_s);
  const int pieces = static_cast<int>(std::ceil(scene.period_s / kContactPeriod_s));
  scene.period_s /= pieces;
  scene::Method coarse;
  if (divisions <= kMaxDivisions) {
    const int half = static_cast<int>(std::ceil(std::max(1.0, 0.5 * divisions / pieces)));
    coarse = verlet(half);
    choice.reference = verlet(2 * half);
  } else {
    choice.reference = {.integrator = scene::IntegratorKind::kCvodeBdf,
                        .tolerance_m_s = kReferenceTolerance_m_s};
    coarse = choice.reference;
    coarse.tolerance_m_s *= 10.0;
  }
  tell("reference: " + scene::describe(choice.reference));
  const Run fine = run_trial(scene, choice.load, choice.reference, pieces * steps, kInfinity);
  const Run rough = run_trial(scene, choice.load, coarse, pieces * steps, kInfinity);
  if (fine.failure.empty() && rough.failure.empty())
    choice.error_floor_m = rms_distance_m(fine.end, rough.end);
  else
    choice.error_floor_m = kInfinity;
  return fine.end;
}

/// Tries each method, and measures its cost and error.
void make_trials(const scene::SceneDescription& scene, int steps, const Positions& reference,
                 double enough_m, const Tell& tell, MethodChoice& choice) {
  double best_ms = kHopeless * 1e3 * scene.period_s;  // a step's
  for (const scene::Method& method : candidates(scene)) {
    MethodTrial& trial = choice.trials.emplace_back(MethodTrial{.method = method});
    tell("trying " + scene::describe(method));
    const Run run = run_trial(scene, choice.load, method, steps, steps * best_ms);
    trial.step_ms = run.step_ms;
    trial.refusal = run.failure;
    if (!run.failure.empty()) continue;
    if (reference.size() != run.end.size()) {
      trial.refusal = "its error is unknown: no reference converged";
      continue;
    }
    trial.error_m = rms_distance_m(run.end, reference);
    if (*trial.error_m <= enough_m) best_ms = std::min(best_ms, run.step_ms);
  }
}

/// Chooses the cheapest trial of those that keep the target; else the most accurate in time.
void choose(MethodChoice& choice, double enough_m, double target_m, double period_s) {
  MethodTrial* best = nullptr;
  const auto in_time = [&](const MethodTrial& t) {
    return *t.step_ms <= kRateShare * 1e3 * period_s;
  };
  const auto better = [&](const MethodTrial& a, const MethodTrial& b) {
    const bool a_meets = *a.error_m <= enough_m, b_meets = *b.error_m <= enough_m;
    if (in_time(a) != in_time(b)) return in_time(a);
    if (a_meets != b_meets) return a_meets;
    return a_meets ? *a.step_ms < *b.step_ms : *a.error_m < *b.error_m;
  };
  for (MethodTrial& trial : choice.trials)
    if (trial.refusal.empty() && (best == nullptr || better(trial, *best))) best = &trial;
  if (best == nullptr) return;
  choice.method = best->method;
  choice.keeps_rate = in_time(*best);
  choice.meets_target = *best->error_m <= target_m;
  for (MethodTrial& trial : choice.trials) {
    if (&trial == best || !trial.refusal.empty()) continue;
    trial.refusal = !in_time(trial)             ? "misses the rate"
                    : *trial.error_m > enough_m ? "misses the error target"
                                                : "costs more than the chosen one";
  }
}

}  // namespace

MethodChoice choose_method(const scene::SceneDescription& scene, const Tell& tell) {
  MethodChoice choice;
  choice.load = load_of(scene::build_world(scene));
  const int steps = steps_of(choice.load, scene.period_s);
  choice.simulated_s = steps * scene.period_s;
  const Positions reference = run_reference(scene, steps, tell, choice);
  const double enough_m = std::max(scene.error_target_m, 2.0 * choice.error_floor_m);
  make_trials(scene, steps, reference, enough_m, tell, choice);
  choose(choice, enough_m, scene.error_target_m, scene.period_s);

  tell("at 1 kHz");
  scene::SceneDescription haptic = scene;
  haptic.period_s = 1e-3;
  const Run fast = run_trial(haptic, choice.load, verlet(0), kHapticSteps, kInfinity);
  choice.haptic_ms = fast.step_ms;
  choice.fits_haptic_rate = fast.failure.empty() && choice.haptic_ms <= kHapticShare;
  return choice;
}

}  // namespace stillgrid::dynamics
