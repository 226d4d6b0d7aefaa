// The force on one probe among N static spheres: the 1 kHz side's query, beside Bullet's and
// nanoflann's trees in the same run.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <map>

#include "shared/collision/grid_query.hpp"
#include "shared/collision/sphere_history.hpp"
#include "shared/collision/touch_lists.hpp"
#include "shared/collision/voxel_grid.hpp"
#include "shared/publication/scene_segment.hpp"
#include "tests/performance/query_peers.hpp"
#include "tests/performance/sphere_cloud.hpp"

namespace stillgrid::performance {
namespace {

constexpr auto kRadius_m = static_cast<float>(SphereCloud::kRadius_m);

std::vector<PlainSphere> static_spheres(const SphereCloud& cloud) {
  std::vector<PlainSphere> spheres;
  for (std::size_t i = 0; i < cloud.count(); ++i) {
    const Eigen::Vector3f p = cloud.position_m(i).cast<float>();
    spheres.push_back({p.x(), p.y(), p.z(), cloud.radius_m(i)});
  }
  return spheres;
}

PlainSphere probe_at(const Eigen::Vector3d& place_m) {
  const Eigen::Vector3f p = place_m.cast<float>();
  return {p.x(), p.y(), p.z(), kRadius_m};
}

void write_records(std::span<const PlainSphere> spheres, std::span<proto::SphereRecord> records) {
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const auto& [x_m, y_m, z_m, radius_m] = spheres[i];
    const proto::SphereState snapshot{{x_m, y_m, z_m}, {}};
    collision::fill_history(records[i], snapshot);
    records[i].radius_m = radius_m;
  }
}

/// The touch lists of static spheres, as a tick searches them.
class OurLists {
 public:
  explicit OurLists(std::span<const PlainSphere> spheres) : lists_(lists_of(spheres)) {
    view_ = collision::TouchView(lists_.shape(), static_cast<std::uint32_t>(spheres.size()),
                                 lists_.words().data());
  }

  [[nodiscard]] Eigen::Vector3f force_N(const PlainSphere& probe) const {
    Eigen::Vector3f sum_N = Eigen::Vector3f::Zero();
    const auto& [x_m, y_m, z_m, radius_m] = probe;
    view_.for_each_touch({{x_m, y_m, z_m}, radius_m}, 8192,
                         [&](const collision::TouchEntry& entry) {
                           const auto& p = entry.centre_m;
                           sum_N += push_N(probe, {p[0], p[1], p[2], entry.radius_m});
                         });
    return sum_N;
  }

 private:
  static collision::TouchLists lists_of(std::span<const PlainSphere> spheres) {
    std::vector<proto::SphereRecord> records(spheres.size());
    write_records(spheres, records);
    return {records, publication::touch_probe_radius_m(kRadius_m)};
  }

  collision::TouchLists lists_;
  collision::TouchView view_;
};

/// The grid that each sphere is entered in once, as a tick searches that of moving spheres.
class OurGrid {
 public:
  explicit OurGrid(std::span<const PlainSphere> spheres) : grid_(0, spheres.size()) {
    write_records(spheres, grid_.records());
    grid_.enter(collision::history_bounds(grid_.records()), publication::StaticScene{}.voxel_ratio);
    view_ = grid_.view();
  }

  /// Reads positions from records, as a tick does, for covers need not be spheres.
  [[nodiscard]] Eigen::Vector3f force_N(const PlainSphere& probe) const {
    Eigen::Vector3f sum_N = Eigen::Vector3f::Zero();
    const auto& [x_m, y_m, z_m, radius_m] = probe;
    collision::for_each_candidate(
        view_, {{x_m, y_m, z_m}, radius_m}, 8192, [&](std::uint32_t sphere) {
          const collision::RecordLine line = collision::load_line(view_, sphere);
          const auto& p = line.newest.position_m;
          sum_N += push_N(probe, {p[0], p[1], p[2], line.radius_m});
        });
    return sum_N;
  }

 private:
  collision::VoxelGrid grid_;
  collision::GridView view_;
};

/// A method over a cloud of spheres, made once, and whether it sums the same forces as trying every
/// sphere in turn.
template <class Method>
struct Checked {
  explicit Checked(std::size_t count) : cloud(count), method(static_spheres(cloud)) {
    const std::vector<PlainSphere> spheres = static_spheres(cloud);
    for (int i = 0; i < 50; ++i) {
      const PlainSphere probe = probe_at(cloud.place_within());
      Eigen::Vector3f sum_N = Eigen::Vector3f::Zero();
      for (const PlainSphere& sphere : spheres) sum_N += push_N(probe, sphere);
      is_right = is_right && (method.force_N(probe) - sum_N).norm() < 1e-4F;
    }
  }
  SphereCloud cloud;
  Method method;
  bool is_right = true;
};

template <class Method>
Checked<Method>& checked(benchmark::State& state) {
  static std::map<std::size_t, Checked<Method>> made;
  const auto count = static_cast<std::size_t>(state.range(0));
  Checked<Method>& found = made.try_emplace(count, count).first->second;
  if (!found.is_right) state.SkipWithError("the force is not the sum over all spheres");
  return found;
}

/// A probe that creeps on a small circle in the middle: the same few spheres all the time.
template <class Method>
void query_hot(benchmark::State& state) {
  const Method& method = checked<Method>(state).method;
  std::vector<PlainSphere> path;
  for (int i = 0; i < 1024; ++i)
    path.push_back(
        probe_at(SphereCloud::kRadius_m *
                 Eigen::Vector3d(std::cos(i * 6.2832 / 1024), std::sin(i * 6.2832 / 1024), 0.1)));
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(method.force_N(path[i++ % 1024]));
}

/// A probe that is anywhere in the cloud at each query; what is searched may stay in the caches.
template <class Method>
void query_anywhere(benchmark::State& state) {
  Checked<Method>& found = checked<Method>(state);
  const Method& method = found.method;
  std::vector<PlainSphere> places;
  for (int i = 0; i < 65536; ++i) places.push_back(probe_at(found.cloud.place_within()));
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(method.force_N(places[i++ % 65536]));
}

/// The same with caches flushed, as a tick once a millisecond finds them. Time includes a look at
/// the clock, which the counter tells.
template <class Method>
void query_flushed(benchmark::State& state) {
  Checked<Method>& found = checked<Method>(state);
  const Method& method = found.method;  // a lambda takes no structured binding before clang 16
  CacheFlush flush;
  double clock_s = 0.0;
  std::vector<double> times_s;
  for (auto _ : state) {
    const PlainSphere probe = probe_at(found.cloud.place_within());
    flush();
    clock_s += seconds_of([] {});
    times_s.push_back(seconds_of([&] { benchmark::DoNotOptimize(method.force_N(probe)); }));
    state.SetIterationTime(times_s.back());
  }
  // A query that lost the processor says nothing of its neighbours.
  std::nth_element(times_s.begin(), times_s.begin() + std::ssize(times_s) / 2, times_s.end());
  state.counters["median_ns"] = 1e9 * times_s[times_s.size() / 2];
  state.counters["clock_ns"] =
      benchmark::Counter(1e9 * clock_s, benchmark::Counter::kAvgIterations);
}

void sphere_counts(benchmark::internal::Benchmark* measured) {
  for (const int n : {400, 40000, 400000}) measured->Arg(n);
}

template <class Method>
void add_method(const std::string& name) {
  benchmark::RegisterBenchmark(("query_hot/" + name).c_str(), query_hot<Method>)
      ->Apply(sphere_counts);
  benchmark::RegisterBenchmark(("query_anywhere/" + name).c_str(), query_anywhere<Method>)
      ->Apply(sphere_counts);
  benchmark::RegisterBenchmark(("query_flushed/" + name).c_str(), query_flushed<Method>)
      ->Apply(sphere_counts)
      ->UseManualTime()
      ->Iterations(50);
}

int program_main(int argc, char** argv) {
  add_method<OurLists>("lists");
  add_method<OurGrid>("grid");
  add_method<BulletTree>("Bullet_dbvt");
  add_method<NanoflannTree>("nanoflann");
  benchmark::Initialize(&argc, argv);
  benchmark::AddCustomContext("last_cache_mb", std::to_string(last_cache_bytes() >> 20));
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}

}  // namespace
}  // namespace stillgrid::performance

int main(int argc, char** argv) {
  return stillgrid::performance::program_main(argc, argv);
}
