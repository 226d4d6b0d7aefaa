#include <benchmark/benchmark.h>

#include <functional>
#include <initializer_list>
#include <memory>
#include <string>

#include "tests/performance/pile.hpp"

namespace stillgrid::performance {
namespace {

constexpr int kFallSteps = 50, kSleepSteps = 100;

using MakePile = std::function<std::unique_ptr<PileEngine>(int count)>;

/// One step an iteration, of what fell for half a second, or of what lies and sleeps; it goes on
/// from repetition to repetition.
void step_pile(benchmark::State& state, const std::string& name, const MakePile& make,
               bool is_sleeping) {
  static std::unique_ptr<PileEngine> engine;
  static std::string last;
  const auto count = static_cast<int>(state.range(0));
  if (const std::string key = name + std::to_string(count); key != last) {
    engine.reset();
    engine = make(count);
    last = key;
    for (int i = 0; i < (is_sleeping ? kSleepSteps : kFallSteps); ++i) engine->step();
  }
  if (engine->sleeping() != (is_sleeping ? count : 0))
    return state.SkipWithError("expected all sleeping, or none");
  for (auto _ : state) engine->step();
  state.counters["ns_per_sphere"] = benchmark::Counter(
      1e-9 * count, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["touching_per_sphere"] = static_cast<double>(engine->touching()) / count;
  state.counters["mean_height_mm"] = 1e3 * engine->mean_height_m();
}

void add(const std::string& name, const MakePile& make, bool is_sleeping,
         std::initializer_list<int> counts = {400, 4'000, 40'000, 400'000}) {
  auto* const added = benchmark::RegisterBenchmark(
      name.c_str(), [=](benchmark::State& state) { step_pile(state, name, make, is_sleeping); });
  for (const int count : counts) added->Arg(count);
  added->MeasureProcessCPUTime()->Unit(benchmark::kMicrosecond);
}

}  // namespace
}  // namespace stillgrid::performance

int main(int argc, char** argv) {
  using namespace stillgrid::performance;
  add(
      "awake/ours", [](int n) { return our_pile(falling_pile(n), false, false); }, false);
  add(
      "awake/ours_two_threads", [](int n) { return our_pile(falling_pile(n), false, false, 2); },
      false);
  add(
      "awake/ours_predicting", [](int n) { return our_pile(falling_pile(n), false, true); }, false);
  add(
      "awake/Bullet", [](int n) { return bullet_pile(falling_pile(n), false); }, false);
  if (mujoco_pile(falling_pile(1)))
    add("awake/MuJoCo", [](int n) { return mujoco_pile(falling_pile(n)); }, false, {400});
  add(
      "sleeping/ours", [](int n) { return our_pile(lying_spheres(n), true, false); }, true);
  add(
      "sleeping/ours_predicting", [](int n) { return our_pile(lying_spheres(n), true, true); },
      true);
  add(
      "sleeping/Bullet", [](int n) { return bullet_pile(lying_spheres(n), true); }, true);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
