// Error against time of every method on every scene: prints docs/charts/work_precision.csv for
// scripts/gallery/measure_work_precision.py, scene after scene.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>

#include "tests/performance/work_precision_bullet.hpp"
#include "tests/performance/work_precision_mujoco.hpp"
#include "tests/performance/work_precision_reference.hpp"

namespace stillgrid::performance {
namespace {

struct Measured {
  ChartPoint point;
  RunResult first;
  std::vector<double> ms_per_10ms;
};

RunResult run_point(const ChartScene& scene, const ChartPoint& point) {
  const double rivals_s = 3.0 * scene.limit_s;
  if (point.integrator == "bullet") return run_bullet(scene, point, rivals_s);
  if (point.integrator == "mujoco") return run_mujoco(scene, point, rivals_s);
  const bool is_sundials = scene::chooses_steps(point.method.integrator);
  return run_ours(scene, point, is_sundials ? rivals_s : scene.limit_s);
}

double ms_per_10ms(const RunResult& run) {
  return 10.0 * run.worked_s / std::max(run.simulated_s, 1e-9);
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const double place = share * double(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const auto above = std::min(below + 1, values.size() - 1);
  return values[below] + (place - double(below)) * (values[above] - values[below]);
}

/// A curve's points once each. Once too slow, finer ones are left out: but a long step may be too
/// slow because it is hard to solve or unstable, where shorter ones are not.
void measure_curve(const ChartScene& scene, const Curve& curve, std::vector<Measured>& measured) {
  for (const ChartPoint& point : curve) {
    Measured one{point, run_point(scene, point), {}};
    one.ms_per_10ms.push_back(ms_per_10ms(one.first));
    measured.push_back(std::move(one));
    if (measured.back().first.end == RunEnd::kTooSlow && point.value < 0.002) break;
  }
}

void print_row(const ChartScene& scene, const Measured& measured,
               const std::vector<Eigen::Matrix3Xd>& reference_m) {
  const auto& [point, run, ms] = measured;
  const Errors errors = errors_of(scene, run, reference_m);
  std::printf("%s,%s,%s,%s,%g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%zu,%ld,%ld,%ld,%s\n",
              scene.name.c_str(), point.integrator.c_str(), point.solver.c_str(),
              point.knob.c_str(), point.value, errors.early_m, errors.end_m, errors.rest_m,
              quantile(ms, 0.5), quantile(ms, 0.25), quantile(ms, 0.75), ms.size(), run.iterations,
              run.substeps, run.missed, name_of(run.end));
}

void print_floor(const ChartScene& scene, const char* what, const char* knob, double value,
                 const Errors& errors) {
  std::printf("%s,%s,,%s,%g,%.4g,%.4g,%.4g,,,,,,,,done\n", scene.name.c_str(), what, knob, value,
              errors.early_m, errors.end_m, errors.rest_m);
}

void measure_scene(const ChartScene& scene, int rounds) {
  const Reference reference = make_reference(scene);
  if (reference.step_s > 0.0) {
    print_floor(scene, "reference", "step_s", reference.step_s, reference.on_halving);
    print_floor(scene, "disturbance", "shift_m", kDisturbance_m, reference.disturbed);
  }
  std::vector<Curve> curves = our_curves(scene);
  for (const auto& rivals_curves : {bullet_curves, mujoco_curves})
    for (Curve& curve : rivals_curves(scene)) curves.push_back(std::move(curve));
  curves.push_back(auto_curve(scene));
  std::vector<Measured> measured;
  for (const Curve& curve : curves) measure_curve(scene, curve, measured);
  // All in turn, so that what else the machine does falls on all alike; long runs less often.
  for (int round = 1; round < rounds; ++round)
    for (Measured& one : measured) {
      const bool ended = one.first.end == RunEnd::kDone || one.first.end == RunEnd::kNotConverged;
      if (!ended || one.first.worked_s * (round + 1) > 0.3 * scene.limit_s) continue;
      one.ms_per_10ms.push_back(ms_per_10ms(run_point(scene, one.point)));
    }
  for (const Measured& one : measured) print_row(scene, one, reference.places_m);
  std::fflush(stdout);
}

int program_main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 0;
  if (rounds < 1) {
    std::fprintf(stderr, "usage: work_precision ROUNDS [SCENE...]\n");
    return 2;
  }
  std::printf(
      "scene,integrator,solver,knob,value,early_m,error_m,rest_m,ms_per_10ms,p25_ms,p75_ms,"
      "runs,iterations,substeps,missed,status\n");
  for (const ChartScene& scene : chart_scenes()) {
    const bool asked = argc == 2 || std::any_of(argv + 2, argv + argc, [&](const char* name) {
                         return scene.name == name;
                       });
    if (asked) measure_scene(scene, rounds);
  }
  return 0;
}

}  // namespace
}  // namespace stillgrid::performance

int main(int argc, char** argv) {
  return stillgrid::performance::program_main(argc, argv);
}
