#pragma once

#include <Eigen/Core>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "sim_server/scene/method.hpp"
#include "tests/performance/work_precision_scenes.hpp"

namespace stillgrid::performance {

/// A point of the chart: a method with its knob set.
struct ChartPoint {
  std::string integrator, solver, knob;
  double value = 0.0;  // of the knob
  double period_s = 0.01;
  scene::Method method;
};

/// The points of one curve, from the coarsest to the finest.
using Curve = std::vector<ChartPoint>;

/// How a run ended.
enum class RunEnd { kDone, kDiverged, kNotConverged, kTooSlow };
[[nodiscard]] const char* name_of(RunEnd end);

/// What came of a run.
struct RunResult {
  RunEnd end = RunEnd::kDone;
  double simulated_s = 0.0, worked_s = 0.0;       // processor time of the stepping alone
  long iterations = 0, substeps = 0, missed = 0;  // missed: steps that did not converge
  std::vector<Eigen::Matrix3Xd> places_m;         // at the scene's early, end and rest times
};

/// Steps a simulation through a scene's times. step() moves it on by one period, places() tells
/// where all is; the clock runs only while it steps. Ends early beyond limit_s of work; a step that
/// throws std::domain_error met what is no number.
[[nodiscard]] RunResult run_through(const ChartScene& scene, double period_s, double limit_s,
                                    const std::function<void(RunResult&)>& step,
                                    const std::function<Eigen::Matrix3Xd()>& places);

/// A run of one of ours, through Simulation as sim_server steps it. shift_m is added to where free
/// nodes and bodies begin, a column each as in positions_m(); without columns to none.
[[nodiscard]] RunResult run_ours(const ChartScene& scene, const ChartPoint& point, double limit_s,
                                 const Eigen::Matrix3Xd& shift_m = {});

/// What integrator = "auto" chooses at 10 ms for error targets of 10, 1 and 0.1 mm. Takes seconds.
[[nodiscard]] Curve auto_curve(const ChartScene& scene);

/// The curves of ours that a scene is measured with.
[[nodiscard]] std::vector<Curve> our_curves(const ChartScene& scene);

/// Root mean square errors at the scene's early and end times, infinite where the run did not come;
/// at its rest time that of the heights of free rigid bodies, or nothing.
struct Errors {
  double early_m = 0.0, end_m = 0.0, rest_m = 0.0;
};
[[nodiscard]] Errors errors_of(const ChartScene& scene, const RunResult& run,
                               const std::vector<Eigen::Matrix3Xd>& reference_m);

}  // namespace stillgrid::performance
