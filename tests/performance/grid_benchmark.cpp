#include <benchmark/benchmark.h>

#include "shared/collision/contact_law.hpp"
#include "shared/collision/grid_query.hpp"
#include "shared/collision/still_grid.hpp"
#include "tests/performance/sphere_cloud.hpp"

namespace stillgrid {
namespace {

/// Entering the spheres alone; they were moved before, outside the time.
void fill_grid(benchmark::State& state) {
  SphereCloud cloud(static_cast<std::size_t>(state.range(0)));
  StillGrid grid(0, cloud.count());
  for (auto _ : state) {
    cloud.move();
    cloud.write_to(grid.records());
    state.SetIterationTime(seconds_of([&] { grid.fill(cloud.count(), SphereCloud::voxel_m()); }));
  }
}

/// Entering the spheres, and all pairs of them that overlap: what others call collision detection.
/// The boxes are of one image, as the simulation's, not swept over a history.
void detect_pairs(benchmark::State& state) {
  SphereCloud cloud(static_cast<std::size_t>(state.range(0)));
  StillGrid grid(0, cloud.count());
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  std::size_t found = 0;
  for (auto _ : state) {
    cloud.move();
    const auto records = grid.records();
    cloud.write_to(records);
    for (proto::SphereRecord& record : records) {
      record.newest[1] = record.newest[0];
      record.older = record.newest;
    }
    pairs.clear();
    state.SetIterationTime(seconds_of([&] {
      grid.fill(cloud.count(), SphereCloud::voxel_m());
      for_each_pair(grid.view(), [&](std::uint32_t a, std::uint32_t b) {
        const auto &p = records[a].newest[0].position_m, &q = records[b].newest[0].position_m;
        const float x = p[0] - q[0], y = p[1] - q[1], z = p[2] - q[2];
        const float reach_m = records[a].radius_m + records[b].radius_m;
        if (x * x + y * y + z * z < reach_m * reach_m) pairs.emplace_back(a, b);
      });
    }));
    found += pairs.size();
  }
  state.counters["overlaps_each"] =
      benchmark::Counter(2.0 * static_cast<double>(found) / static_cast<double>(cloud.count()),
                         benchmark::Counter::kAvgIterations);
}

/// The force of all spheres on one probe of their size, as the 1 kHz side sums it.
Eigen::Vector3d force_on_probe_N(const GridView& view, const Eigen::Vector3d& probe_m) {
  constexpr ContactMaterial kMaterial{500.0, 1.0, 0.3, 1e-3};
  constexpr double kRadius_m = SphereCloud::kRadius_m;
  const Eigen::Vector3f low = (probe_m.array() - kRadius_m).cast<float>();
  const Eigen::Vector3f high = (probe_m.array() + kRadius_m).cast<float>();
  Eigen::Vector3d sum_N = Eigen::Vector3d::Zero();
  for_each_candidate(
      view, {{low.x(), low.y(), low.z()}, {high.x(), high.y(), high.z()}}, kAllVisits,
      [&](std::uint32_t /*sphere*/, const RecordLine& line) {
        const auto& [position, velocity] = line.newest[0];
        const Eigen::Vector3d apart_m =
            probe_m - Eigen::Vector3d(position[0], position[1], position[2]);
        const double reach_m = kRadius_m + line.radius_m, distance_m2 = apart_m.squaredNorm();
        if (!(distance_m2 < reach_m * reach_m) || distance_m2 == 0.0) return;
        const double distance_m = std::sqrt(distance_m2);
        sum_N += contact_force_N(kMaterial, reach_m - distance_m, apart_m / distance_m,
                                 -Eigen::Vector3d(velocity[0], velocity[1], velocity[2]));
      });
  return sum_N;
}

StillGrid filled_grid(const SphereCloud& cloud) {
  StillGrid grid(0, cloud.count());
  cloud.write_to(grid.records());
  grid.fill(cloud.count(), SphereCloud::voxel_m());
  return grid;
}

/// A probe that creeps on a small circle in the middle: the same few voxels all the time.
void query_hot(benchmark::State& state) {
  const SphereCloud cloud(static_cast<std::size_t>(state.range(0)));
  const StillGrid grid = filled_grid(cloud);
  const GridView view = grid.view();
  std::vector<Eigen::Vector3d> path_m;
  for (int i = 0; i < 1024; ++i)
    path_m.emplace_back(SphereCloud::kRadius_m * Eigen::Vector3d(std::cos(i * 6.2832 / 1024),
                                                                 std::sin(i * 6.2832 / 1024), 0.1));
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(force_on_probe_N(view, path_m[i++ % 1024]));
}

/// A probe that is anywhere in the cloud at each query; the grid may stay in the caches.
void query_anywhere(benchmark::State& state) {
  SphereCloud cloud(static_cast<std::size_t>(state.range(0)));
  const StillGrid grid = filled_grid(cloud);
  const GridView view = grid.view();
  std::vector<Eigen::Vector3d> places_m;
  for (int i = 0; i < 65536; ++i) places_m.push_back(cloud.place_within());
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(force_on_probe_N(view, places_m[i++ % 65536]));
}

/// The same with caches flushed, as a tick once a millisecond finds them. Time includes a look at
/// the clock, which the counter tells.
void query_flushed(benchmark::State& state) {
  SphereCloud cloud(static_cast<std::size_t>(state.range(0)));
  const StillGrid grid = filled_grid(cloud);
  const GridView view = grid.view();
  CacheFlush flush;
  double clock_s = 0.0;
  for (auto _ : state) {
    const Eigen::Vector3d probe_m = cloud.place_within();
    flush();
    clock_s += seconds_of([] {});
    state.SetIterationTime(
        seconds_of([&] { benchmark::DoNotOptimize(force_on_probe_N(view, probe_m)); }));
  }
  state.counters["clock_ns"] =
      benchmark::Counter(1e9 * clock_s, benchmark::Counter::kAvgIterations);
}

BENCHMARK(fill_grid)->Name("fill/grid")->Arg(400)->Arg(4000)->Arg(40000)->UseManualTime();
BENCHMARK(detect_pairs)->Name("detect/grid")->Arg(400)->Arg(4000)->Arg(40000)->UseManualTime();
BENCHMARK(query_hot)->Name("query_hot/grid")->Arg(400)->Arg(40000);
BENCHMARK(query_anywhere)->Name("query_anywhere/grid")->Arg(400)->Arg(40000);
BENCHMARK(query_flushed)
    ->Name("query_flushed/grid")
    ->Arg(400)
    ->Arg(40000)
    ->UseManualTime()
    ->Iterations(25);

}  // namespace
}  // namespace stillgrid
