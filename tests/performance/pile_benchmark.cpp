// Awake piles of balls by the engine of both processes: time, with the overlap that it has bought.
#include <benchmark/benchmark.h>

#include <algorithm>

#include "tests/shared/dynamics/engine_scenes.hpp"

namespace stillgrid::performance {
namespace {

constexpr int kTicks = 10, kFallTicks = 500;  // of 1 ms: those timed at once, those of the fall

/// Returns the mean depth of overlapping pairs of balls, in mm.
double overlap_mm(const dynamics::Engine& engine) {
  double sum_m = 0.0;
  int count = 0;
  const dynamics::RowList& list = engine.listing().rows();
  for (const dynamics::RowGroup& group : list.groups)
    for (std::size_t row = group.first; row < group.end; ++row)
      for (const float depth_m : list.rows[row].depth_m) {
        if (group.b == dynamics::SideKind::kPlane || !(depth_m > 0.0F)) continue;
        sum_m += static_cast<double>(depth_m);
        ++count;
      }
  return 1e3 * sum_m / std::max(1, count);
}

/// Counter per_ball: time per ball and 10 ms.
void fall_and_pile(benchmark::State& state) {
  const auto balls = static_cast<int>(state.range(0));
  dynamics::Engine engine = dynamics::falling_pile(balls).engine();
  for (int tick = 0; tick < kFallTicks; ++tick) engine.step();
  const std::size_t listings = engine.listing().listings();
  for (auto _ : state)
    for (int tick = 0; tick < kTicks; ++tick) engine.step();
  const auto steps = static_cast<double>(state.iterations());
  state.counters["per_ball"] =
      benchmark::Counter(balls * steps, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["overlap_mm"] = overlap_mm(engine);
  state.counters["listings"] =
      static_cast<double>(engine.listing().listings() - listings) / (kTicks * steps);
}
BENCHMARK(fall_and_pile)
    ->Arg(400)
    ->Arg(4'000)
    ->Arg(40'000)
    ->Iterations(50)  // 0.5 s from 0.5 s on: alike for all
    ->Unit(benchmark::kMillisecond);

/// Counters: speed after over speed before a bounce without dampers at 0.3 m/s, over the phases of
/// a tick.
void bounce(benchmark::State& state) {
  constexpr int kPhases = 40;
  constexpr double kSpeed_m_s = 0.3, kRadius_m = 0.01;
  double least = 1.0, most = 1.0;
  for (auto _ : state)
    for (int phase = 0; phase < kPhases; ++phase) {
      dynamics::EngineScene scene;
      scene.description.materials = {{1000.0, 0.0, 0.0}};
      scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
      const double above_m = kSpeed_m_s * dynamics::kTick_s * (1.0 + phase / double{kPhases});
      scene.add_ball(kRadius_m, {0.0, 0.0, kRadius_m + above_m});
      scene.state.rigid_velocity_m_s[0] = {0.0, 0.0, -kSpeed_m_s};
      dynamics::Engine engine = scene.engine();
      for (int tick = 0; tick < 40; ++tick) engine.step();
      const double ratio = engine.state().rigid_velocity_m_s[0].z / kSpeed_m_s;
      least = std::min(least, ratio);
      most = std::max(most, ratio);
    }
  state.counters["least"] = least;
  state.counters["most"] = most;
}
BENCHMARK(bounce)->Iterations(1);

}  // namespace
}  // namespace stillgrid::performance
