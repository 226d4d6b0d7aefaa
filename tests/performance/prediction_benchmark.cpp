// What a prediction with its modes costs beside the step before it, on the shipped scenes under
// their hands; without a budget, in the steps of which something gives way.
#include <benchmark/benchmark.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "shared/realtime/percentile.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/hand_path.hpp"
#include "sim_server/scene/scene_file.hpp"

namespace stillgrid::performance {
namespace {

double seconds_of(const std::function<void()>& work) {
  const auto began = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
}

void beside_step(benchmark::State& state, const std::string& name) {
  const std::filesystem::path root = STILLGRID_SOURCE_DIR;
  const scene::SceneDescription scene =
      scene::load_scene(root / "sim_server/scene/scenes" / (name + ".toml"));
  const sim_server::HandPath hand(scene.hand->file, scene.device);
  dynamics::Simulation simulation(scene);
  while (simulation.world().time_s < scene.hand->settle_s)
    (void)simulation.step(scene.period_s, [] { return std::nullopt; });
  const double from_s = simulation.world().time_s;
  std::vector<double> step_s, prediction_s;
  double modes = 0.0;
  for (auto _ : state) {
    const double t_s = simulation.world().time_s + scene.period_s;
    const sim_server::HandPose pose = hand.at(t_s - from_s);
    const dynamics::ToolSample tool{static_cast<std::uint64_t>(1e9 * t_s), pose.position_m,
                                    pose.orientation, Eigen::Vector3d::Zero()};
    const double one_step_s =
        seconds_of([&] { (void)simulation.step(scene.period_s, [&] { return tool; }); });
    std::size_t count = 0;
    const double one_prediction_s =
        seconds_of([&] { count = simulation.predict_next(scene.period_s).modes.size(); });
    state.SetIterationTime(one_prediction_s);
    if (count == 0) continue;
    modes += static_cast<double>(count);
    step_s.push_back(one_step_s);
    prediction_s.push_back(one_prediction_s);
  }
  if (step_s.empty()) return state.SkipWithError("nothing gave way");
  modes /= static_cast<double>(step_s.size());
  state.counters["step_us"] = 1e6 * realtime::percentile(step_s, 0.5);
  state.counters["predict_us"] = 1e6 * realtime::percentile(prediction_s, 0.5);
  state.counters["predict_p99_us"] = 1e6 * realtime::percentile(prediction_s, 0.99);
  state.counters["of_a_period"] = realtime::percentile(prediction_s, 0.5) / scene.period_s;
  state.counters["modes"] = modes;
}

void steps_of(benchmark::internal::Benchmark* benchmark, int iterations) {
  benchmark->UseManualTime()->Iterations(iterations)->Unit(benchmark::kMicrosecond);
}
void slow(benchmark::internal::Benchmark* benchmark) {
  steps_of(benchmark, 150);
}
void fast(benchmark::internal::Benchmark* benchmark) {
  steps_of(benchmark, 1000);
}
BENCHMARK_CAPTURE(beside_step, tissue_and_blocks, "tissue_and_blocks")->Apply(fast);
BENCHMARK_CAPTURE(beside_step, threads, "threads")->Apply(slow);
BENCHMARK_CAPTURE(beside_step, organ, "organ")->Apply(slow);
BENCHMARK_CAPTURE(beside_step, laparoscopy, "laparoscopy")->Apply(fast);

}  // namespace
}  // namespace stillgrid::performance
