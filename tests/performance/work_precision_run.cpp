#include "tests/performance/work_precision_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "sim_server/dynamics/choice/counted_work.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/scene/build_world.hpp"
#include "tests/laboratory/methods/broyden.hpp"

namespace stillgrid::performance {
namespace {

/// Processor time of this thread: what the machine gives to others does not count.
double processor_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

/// What an implicit step may leave of a velocity's error grows with the step, so that all steps
/// together leave as little: a hundredth of a metre per second in a second.
double loose_tolerance_m_s(double step_s) {
  return 1e-2 * step_s;
}

Curve implicit_curve(const scene::IntegratorKind& integrator) {
  Curve curve;
  for (const double step_s : {0.05, 0.025, 0.01, 0.005, 0.0025, 0.001, 0.0005, 0.00025, 0.0001})
    curve.push_back(
        {std::string(scene::name_of(integrator)), "", "step_s", step_s, step_s,
         scene::Method{.integrator = integrator, .tolerance_m_s = loose_tolerance_m_s(step_s)}});
  return curve;
}

Curve explicit_curve(const scene::IntegratorKind& integrator) {
  Curve curve;
  for (const int substeps : {4, 10, 20, 40, 100, 200, 400, 1000})
    curve.push_back({std::string(scene::name_of(integrator)), "", "step_s", 0.01 / substeps, 0.01,
                     scene::Method{.integrator = integrator, .substeps = substeps}});
  return curve;
}

Curve adaptive_curve(const scene::IntegratorKind& integrator) {
  Curve curve;
  for (const double tolerance : {1e-1, 3e-2, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6})
    curve.push_back({std::string(scene::name_of(integrator)), "", "tolerance", tolerance, 0.01,
                     scene::Method{.integrator = integrator, .tolerance_m_s = tolerance}});
  return curve;
}

}  // namespace

const char* name_of(RunEnd end) {
  switch (end) {
    case RunEnd::kDone:
      return "done";
    case RunEnd::kDiverged:
      return "diverged";
    case RunEnd::kNotConverged:
      return "not_converged";
    case RunEnd::kTooSlow:
      return "too_slow";
  }
  return "";
}

RunResult run_through(const ChartScene& scene, double period_s, double limit_s,
                      const std::function<void(RunResult&)>& step,
                      const std::function<Eigen::Matrix3Xd()>& places) {
  // Farther than anything of these scenes can go.
  constexpr double kFar_m = 10.0;
  RunResult run;
  long steps = 0;
  for (const double until_s : {scene.early_s, scene.end_s, scene.rest_s}) {
    const double from_s = processor_s();
    double now_s = from_s;
    for (const long last = std::lround(until_s / period_s); steps < last; ++steps) {
      try {
        step(run);
      } catch (const std::domain_error&) {  // places that are no numbers are refused
        run.end = RunEnd::kDiverged;
      }
      now_s = processor_s();
      if (run.end != RunEnd::kDone) break;
      if (run.worked_s + now_s - from_s > limit_s) {
        run.end = RunEnd::kTooSlow;
        break;
      }
    }
    run.worked_s += now_s - from_s;
    run.simulated_s = static_cast<double>(steps) * period_s;
    if (until_s <= 0.0) break;
    run.places_m.push_back(places());
    if (!run.places_m.back().allFinite() || run.places_m.back().cwiseAbs().maxCoeff() > kFar_m)
      run.end = RunEnd::kDiverged;
    if (run.end != RunEnd::kDone) return run;
  }
  if (run.missed > 0) run.end = RunEnd::kNotConverged;
  return run;
}

RunResult run_ours(const ChartScene& scene, const ChartPoint& point, double limit_s,
                   const Eigen::Matrix3Xd& shift_m) {
  scene::SceneDescription description = scene.scene;
  description.method = point.method;
  description.period_s = point.period_s;
  dynamics::Simulation simulation(description);
  Eigen::Index column = 0;
  if (shift_m.cols() > 0) {
    for (bodies::Node& node : simulation.world().nodes) {
      if (!node.pinned) node.position_m += shift_m.col(column);
      ++column;
    }
    for (bodies::RigidBody& body : simulation.world().rigid_bodies)
      if (body.free) body.position_m += shift_m.col(column++);
  }
  dynamics::Budget budget;  // so that a single step cannot last for ever
  budget.end_within(realtime::to_ns(2.0 * limit_s));
  return run_through(
      scene, point.period_s, limit_s,
      [&](RunResult& run) {
        const dynamics::StepReport report = simulation.step(
            point.period_s, [] { return std::nullopt; }, budget);
        run.iterations += report.solve.iterations;
        run.substeps += report.substeps;
        run.missed += report.solve.converged ? 0 : 1;
        if (report.out_of_budget) run.end = RunEnd::kTooSlow;
      },
      [&] { return positions_m(simulation.world()); });
}

/// The method of integrator = "auto" at several periods.
Curve auto_curve(const ChartScene& scene) {
  Curve curve;
  const dynamics::SceneLoad load = dynamics::load_of(scene::build_world(scene.scene));
  for (const double period_s : {0.02, 0.01, 0.005, 0.001}) {
    const scene::Method method = dynamics::choose_method(load, period_s).method;
    curve.push_back({"auto", scene::describe(method), "period_s", period_s, period_s, method});
  }
  return curve;
}

std::vector<Curve> our_curves(const ChartScene& scene) {
  std::vector<Curve> curves{explicit_curve(scene::IntegratorKind::kVelocityVerlet),
                            implicit_curve(scene::IntegratorKind::kImplicitEuler),
                            implicit_curve(laboratory::kBroyden),
                            adaptive_curve(scene::IntegratorKind::kCvodeBdf)};
  // A step must divide the scene's times.
  for (Curve& curve : curves)
    std::erase_if(curve, [&](const ChartPoint& point) {
      const auto uneven = [&](double time_s) {
        return std::abs(std::remainder(time_s, point.period_s)) > 1e-9;
      };
      return uneven(scene.early_s) || uneven(scene.end_s) || uneven(scene.rest_s);
    });
  return curves;
}

Errors errors_of(const ChartScene& scene, const RunResult& run,
                 const std::vector<Eigen::Matrix3Xd>& reference_m) {
  const double none = std::numeric_limits<double>::infinity();
  const bool whole = run.end == RunEnd::kDone || run.end == RunEnd::kNotConverged;
  Errors errors{none, none, std::nan("")};
  if (!run.places_m.empty() && (whole || run.places_m.size() > 1))
    errors.early_m = rms_distance_m(run.places_m[0], reference_m[0]);
  if (!whole) return errors;
  errors.end_m = rms_distance_m(run.places_m[1], reference_m[1]);
  if (scene.rest_s > 0.0) {
    // Free bodies' centres come after the nodes.
    const auto bodies =
        std::count_if(scene.scene.bodies.begin(), scene.scene.bodies.end(),
                      [](const bodies::BodyDescription& body) {
                        return body.motion == bodies::Motion::kFree && !bodies::is_deformable(body);
                      });
    const auto heights = [&](const Eigen::Matrix3Xd& places_m) {
      return places_m.row(2).tail(bodies);
    };
    errors.rest_m = std::sqrt((heights(run.places_m[2]) - heights(reference_m[2])).squaredNorm() /
                              double(bodies));
  }
  return errors;
}

}  // namespace stillgrid::performance
