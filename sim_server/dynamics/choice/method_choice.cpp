#include "sim_server/dynamics/choice/method_choice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "shared/realtime/percentile.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/scene/build_world.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr double kHorizon_s = 0.5;              // of the scene's time, of each trial
constexpr double kReferenceBudget_ms = 2000.0;  // by prediction
constexpr int kFewestSteps = 8;
constexpr int kReferenceDivision = 4;      // of the stable step
constexpr double kMaxDivisions = 1e4;      // of a period by the explicit reference
constexpr double kContactPeriod_s = 1e-3;  // the reference finds contacts so often
constexpr double kWorthTrying = 12.0;      // predicted cost over the least
constexpr double kCheapTrial_ms = 0.2;     // predicted: tried however the others are
constexpr double kTooSlow = 1.5;           // cost over that of the best so far
constexpr double kRateShare = 0.7;         // of the period, for 9 of 10 steps

using realtime::percentile;
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

/// What one run of a scene by a method showed.
struct Run {
  Positions end;
  std::vector<double> step_ms;
  std::string failure;  // empty: it came to the end
};

/// Runs a scene by one method over `steps` steps. Stops where it has cost far more than a rival up
/// to the same step. rival_ms: of its steps; empty: no rival.
Run run_trial(scene::SceneDescription scene, const scene::Method& method, int steps,
              const std::vector<double>& rival_ms, const std::function<double()>& now_s) {
  scene.method = method;
  scene.sleeping = false;  // what rests now may move when it counts
  Run run;
  try {
    Simulation simulation(scene);
    double spent_ms = 0.0, rival_spent_ms = 0.0;
    for (int step = 0; step < steps; ++step) {
      const double began_s = now_s();
      const StepReport report = simulation.step(scene.period_s, [] { return std::nullopt; });
      run.step_ms.push_back(1e3 * (now_s() - began_s));
      spent_ms += run.step_ms.back();
      if (!report.solve.converged) run.failure = "did not converge";
      const auto i = static_cast<std::size_t>(step);
      if (i < rival_ms.size()) {
        rival_spent_ms += rival_ms[i];
        if (step + 1 >= kFewestSteps && spent_ms > kTooSlow * rival_spent_ms)
          run.failure = "stopped: slower than the best so far";
      }
      if (!run.failure.empty()) return run;
    }
    run.end = positions_of(simulation.world());
  } catch (const std::domain_error& error) {
    run.failure = "unstable";
  }
  return run;
}

scene::Method verlet(int substeps) {
  return {.integrator = scene::IntegratorKind::kVelocityVerlet, .substeps = substeps};
}

/// What a solver may leave: a tenth of the target if each step of the trial errs the same way.
double tolerance_m_s(const scene::SceneDescription& scene) {
  return std::clamp(0.1 * scene.error_target_m / kHorizon_s, 1e-8, 1e-3);
}

std::vector<scene::Method> candidates(const scene::SceneDescription& scene) {
  std::vector<scene::Method> methods = {verlet(0),
                                        {.integrator = scene::IntegratorKind::kSymplecticEuler}};
  for (const scene::IntegratorKind& integrator :
       {scene::IntegratorKind::kImplicitEuler, scene::IntegratorKind::kBdf2})
    for (const scene::SolverKind& solver :
         {scene::SolverKind::kNewton, scene::SolverKind::kNewtonCg})
      for (const int substeps : {1, 2, 4})
        methods.push_back({integrator, solver, substeps, tolerance_m_s(scene)});
  return methods;
}

/// Methods that no trial could make the choice, and why.
std::vector<MethodTrial> refused_untried(const SceneLoad& load, double step_s) {
  const scene::Method trapezoid{.integrator = scene::IntegratorKind::kTrapezoid};
  std::vector<MethodTrial> refused = {
      {.method = trapezoid,
       .predicted_ms = predicted_ms(load, trapezoid, step_s),
       .refusal = "takes out no energy: where contacts set in it rings"}};
  for (const scene::SolverKind& solver :
       {scene::SolverKind::kNewtonLu, scene::SolverKind::kNewtonBicgstab})
    refused.push_back({.method = {.solver = solver},
                       .refusal = "exact Jacobian, for where newton lags friction's pressure"});
  refused.push_back({.method = {.integrator = scene::IntegratorKind::kCvodeBdf},
                     .refusal = "accuracy on demand: its time is not regular"});
  return refused;
}

/// Where the scene is after some steps, as well as it can be told, and how well that is.
struct Reference {
  Positions end;
  double floor_m = 0.0;
};

/// Substeps of a period by which the explicit method errs little.
double divisions_of(const SceneLoad& load, double period_s) {
  return kReferenceDivision * std::ceil(period_s / symplectic_limit_s(load));
}

/// By the explicit method in steps of a quarter of the stable one, or where they would be too many
/// by BDF2; the floor is how far twice the step leads elsewhere.
Reference make_reference(scene::SceneDescription scene, const SceneLoad& load, int steps,
                         const std::function<double()>& now_s,
                         const std::function<void(const std::string&)>& tell) {
  const double divisions = divisions_of(load, scene.period_s);
  const int pieces = static_cast<int>(std::ceil(scene.period_s / kContactPeriod_s));
  scene.period_s /= pieces;
  const auto run = [&](double share) {
    const int substeps = static_cast<int>(std::ceil(std::max(2.0, divisions / pieces) * share));
    const scene::Method method = divisions <= kMaxDivisions
                                     ? verlet(substeps)
                                     : scene::Method{.integrator = scene::IntegratorKind::kBdf2,
                                                     .substeps = static_cast<int>(2.0 * share)};
    tell("reference: " + scene::describe(method) + " of " + std::to_string(1e3 * scene.period_s) +
         " ms");
    return run_trial(scene, method, pieces * steps, {}, now_s);
  };
  const Run fine = run(1.0), coarse = run(0.5);
  if (fine.end.empty() || coarse.end.empty())
    return {fine.end, std::numeric_limits<double>::infinity()};
  return {fine.end, rms_distance_m(fine.end, coarse.end)};
}

/// A heavy scene is watched for less of its time.
int steps_of(const SceneLoad& load, double period_s) {
  const double divisions = std::min(kMaxDivisions, divisions_of(load, period_s));
  const double reference_ms =
      predicted_ms(load, verlet(static_cast<int>(std::max(1.0, divisions))), period_s);
  return static_cast<int>(
      std::clamp(std::min(kHorizon_s / period_s, kReferenceBudget_ms / reference_ms),
                 double(kFewestSteps), 500.0));
}

/// Cheapest prediction first.
std::vector<MethodTrial> trials_to_make(const scene::SceneDescription& scene,
                                        const SceneLoad& load) {
  std::vector<MethodTrial> trials;
  for (const scene::Method& method : candidates(scene))
    trials.push_back(
        {.method = method, .predicted_ms = predicted_ms(load, method, scene.period_s)});
  std::stable_sort(trials.begin(), trials.end(),
                   [](const auto& a, const auto& b) { return *a.predicted_ms < *b.predicted_ms; });
  return trials;
}

/// What each method costs and how far it errs, those apart that are refused on the way.
void make_trials(const scene::SceneDescription& scene, int steps, const Reference& reference,
                 double enough_m, const std::function<double()>& now_s,
                 const std::function<void(const std::string&)>& tell,
                 std::vector<MethodTrial>& trials) {
  const double most_ms = std::max(kCheapTrial_ms, kWorthTrying * *trials.front().predicted_ms);
  std::vector<double> best_ms;  // of each step of the best so far
  double best_total_ms = std::numeric_limits<double>::infinity();
  for (MethodTrial& trial : trials) {
    if (*trial.predicted_ms > most_ms) {
      trial.refusal = "not tried: its predicted cost is far above the least";
      continue;
    }
    tell("trying " + scene::describe(trial.method));
    const Run run = run_trial(scene, trial.method, steps, best_ms, now_s);
    trial.measured_ms = percentile(run.step_ms, 0.5);
    trial.slow_ms = percentile(run.step_ms, 0.9);
    trial.refusal = run.failure;
    if (!run.failure.empty()) continue;
    if (reference.end.size() != run.end.size()) {  // there is none, so that nothing can be told
      trial.refusal = "no reference converged to hold it against";
      continue;
    }
    trial.error_m = rms_distance_m(run.end, reference.end);
    const double total_ms = std::accumulate(run.step_ms.begin(), run.step_ms.end(), 0.0);
    if (*trial.error_m > enough_m || !(total_ms < best_total_ms)) continue;
    best_total_ms = total_ms;
    best_ms = run.step_ms;
  }
}

/// Marks the cheapest of those that err little enough, or the most accurate of those in time.
void choose(MethodChoice& choice, double enough_m, double target_m, double period_s) {
  const double period_ms = 1e3 * period_s;
  MethodTrial* best = nullptr;
  const auto in_time = [&](const MethodTrial& t) { return *t.slow_ms <= kRateShare * period_ms; };
  const auto better = [&](const MethodTrial& a, const MethodTrial& b) {
    const bool a_meets = *a.error_m <= enough_m, b_meets = *b.error_m <= enough_m;
    if (in_time(a) != in_time(b)) return in_time(a);
    if (a_meets != b_meets) return a_meets;
    return a_meets ? *a.measured_ms < *b.measured_ms : *a.error_m < *b.error_m;
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
                                                : "slower than the chosen one";
  }
}

}  // namespace

MethodChoice choose_method(const scene::SceneDescription& scene,
                           const std::function<double()>& now_s,
                           const std::function<void(const std::string&)>& tell) {
  MethodChoice choice;
  choice.load = load_of(scene::build_world(scene));
  const int steps = steps_of(choice.load, scene.period_s);
  choice.simulated_s = steps * scene.period_s;
  const Reference reference = make_reference(scene, choice.load, steps, now_s, tell);
  choice.error_floor_m = reference.floor_m;

  const double enough_m = std::max(scene.error_target_m, 2.0 * reference.floor_m);
  choice.trials = trials_to_make(scene, choice.load);
  make_trials(scene, steps, reference, enough_m, now_s, tell, choice.trials);
  choose(choice, enough_m, scene.error_target_m, scene.period_s);

  tell("at 1 kHz");
  scene::SceneDescription haptic = scene;
  haptic.period_s = 1e-3;
  const Run fast = run_trial(haptic, verlet(0), 200, {}, now_s);
  choice.haptic_ms = percentile(fast.step_ms, 0.9);
  choice.fits_haptic_rate = fast.failure.empty() && choice.haptic_ms <= kHapticShare;

  for (MethodTrial& refused : refused_untried(choice.load, scene.period_s))
    choice.trials.push_back(std::move(refused));
  return choice;
}

}  // namespace stillgrid::dynamics
