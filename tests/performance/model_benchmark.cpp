// What a tick costs with each intermediate model, in a cloud of 400 spheres. tick: while a snapshot
// stands. new_snapshot: the tick that finds a new one, a look at the clock included.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/laboratory/rivals/rivals.hpp"
#include "tests/performance/sphere_cloud.hpp"
#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::performance {
namespace {

constexpr std::size_t kSpheres = 400;
constexpr std::uint64_t kPeriod_ns = 33 * rendering::kMillisecond_ns;

std::vector<float> radii_m(const SphereCloud& cloud) {
  std::vector<float> radii_m;
  for (std::size_t i = 0; i < cloud.count(); ++i) radii_m.push_back(cloud.radius_m(i));
  return radii_m;
}

/// A probe that creeps round the centre of one sphere of a cloud whose snapshots come anew.
struct CrowdedScene {
  SphereCloud cloud{kSpheres};
  rendering::PublishedScene scene{
      rendering::plain_scene(500.0F, static_cast<float>(SphereCloud::kRadius_m)), radii_m(cloud),
      kPeriod_ns};
  std::uint64_t now_ns = 0;
  int ticks = 0;

  void show_next() {
    std::vector<Eigen::Vector3d> places_m;
    for (std::size_t i = 0; i < kSpheres; ++i) places_m.push_back(cloud.position_m(i));
    scene.show(places_m, now_ns += kPeriod_ns);
    cloud.move();
  }
  rendering::RenderedTick tick(rendering::Renderer& renderer) {
    const double angle = 2.0 * std::numbers::pi * ticks++ / 1024.0;
    const rendering::ToolPose pose{.position_m =
                                       cloud.position_m(0) +
                                       SphereCloud::kRadius_m *
                                           Eigen::Vector3d(std::cos(angle), std::sin(angle), 0)};
    return renderer.render(scene.view(), pose, now_ns + 10 * rendering::kMillisecond_ns);
  }
};

void tick(benchmark::State& state, const laboratory::Rival* rival) {
  CrowdedScene crowd;
  const auto renderer = laboratory::make_renderer(rival, display::Transition::kLinear);
  for (int i = 0; i < 4; ++i) crowd.show_next();
  double contacts = 0.0;
  for (auto _ : state) contacts += crowd.tick(*renderer).force.contacts;
  state.counters["contacts"] = benchmark::Counter(contacts, benchmark::Counter::kAvgIterations);
}

void new_snapshot(benchmark::State& state, const laboratory::Rival* rival) {
  CrowdedScene crowd;
  const auto renderer = laboratory::make_renderer(rival, display::Transition::kLinear);
  std::vector<double> times_s;
  for (auto _ : state) {
    crowd.show_next();
    times_s.push_back(
        seconds_of([&] { benchmark::DoNotOptimize(crowd.tick(*renderer).force.force_N); }));
    state.SetIterationTime(times_s.back());
  }
  // A tick that lost the processor says nothing of its neighbours.
  std::nth_element(times_s.begin(), times_s.begin() + std::ssize(times_s) / 2, times_s.end());
  state.counters["median_ns"] = 1e9 * times_s[times_s.size() / 2];
}

int program_main(int argc, char** argv) {
  const auto measure = [](const std::string& name, const laboratory::Rival* rival) {
    benchmark::RegisterBenchmark(("tick/" + name).c_str(), tick, rival);
    benchmark::RegisterBenchmark(("new_snapshot/" + name).c_str(), new_snapshot, rival)
        ->UseManualTime()
        ->Iterations(2000);
  };
  measure("grid", nullptr);
  for (const laboratory::Rival& rival : laboratory::rivals())
    measure(std::string(rival.name), &rival);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}

}  // namespace
}  // namespace stillgrid::performance

int main(int argc, char** argv) {
  return stillgrid::performance::program_main(argc, argv);
}
