#include <benchmark/benchmark.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "sim_server/dynamics/simulation.hpp"
#include "sim_server/scene/scene_file.hpp"

namespace stillgrid {
namespace {

struct RunningScene {
  explicit RunningScene(const SceneDescription& scene)
      : period_s(scene.period_s), simulation(scene) {}
  StepReport step() {
    return simulation.step(period_s, [] { return std::nullopt; });
  }
  double period_s;
  Simulation simulation;
};

/// A shipped scene after five seconds, when what fell lies; it goes on between benchmarks.
RunningScene& settled(const std::string& name) {
  static std::map<std::string, std::unique_ptr<RunningScene>> scenes;
  auto& scene = scenes[name];
  if (!scene) {
    const std::filesystem::path root = STILLGRID_SOURCE_DIR;
    scene = std::make_unique<RunningScene>(
        load_scene(root / "sim_server/scene/scenes" / (name + ".toml")));
    while (scene->simulation.world().time_s < 5.0) (void)scene->step();
  }
  return *scene;
}

double seconds(std::chrono::nanoseconds time) {
  return std::chrono::duration<double>(time).count();
}

/// One phase of a whole step: finding contacts, or solving for the motion.
template <class Phase>
void step_phase(benchmark::State& state, const std::string& scene, Phase phase) {
  RunningScene& running = settled(scene);
  double iterations = 0.0, contacts = 0.0;
  for (auto _ : state) {
    const StepReport report = running.step();
    state.SetIterationTime(seconds(phase(report)));
    iterations += report.solve.iterations;
    contacts += report.contacts;
  }
  state.counters["iterations"] = benchmark::Counter(iterations, benchmark::Counter::kAvgIterations);
  state.counters["contacts"] = benchmark::Counter(contacts, benchmark::Counter::kAvgIterations);
}

void detect(benchmark::State& state, const std::string& scene) {
  step_phase(state, scene, [](const StepReport& report) { return report.detect; });
}
void integrate(benchmark::State& state, const std::string& scene) {
  step_phase(state, scene,
             [](const StepReport& report) { return report.respond + report.integrate; });
}

BENCHMARK_CAPTURE(detect, tissue, "tissue_and_blocks")
    ->Name("step_detect/tissue_and_blocks")
    ->UseManualTime()
    ->Iterations(20);
BENCHMARK_CAPTURE(integrate, tissue, "tissue_and_blocks")
    ->Name("step_integrate/tissue_and_blocks")
    ->UseManualTime()
    ->Iterations(20);
BENCHMARK_CAPTURE(detect, threads, "threads")
    ->Name("step_detect/threads")
    ->UseManualTime()
    ->Iterations(50);
BENCHMARK_CAPTURE(integrate, threads, "threads")
    ->Name("step_integrate/threads")
    ->UseManualTime()
    ->Iterations(50);

}  // namespace
}  // namespace stillgrid
