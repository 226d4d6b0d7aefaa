#include <benchmark/benchmark.h>

#include <cstdint>
#include <cstring>
#include <vector>

#include "shared/collision/sphere_history.hpp"
#include "shared/publication/scene_segment.hpp"
#include "tests/performance/sphere_cloud.hpp"

namespace stillgrid::performance {
namespace {

/// One snapshot only, as a first publication has.
collision::VoxelGrid first_snapshot(const SphereCloud& cloud) {
  collision::VoxelGrid grid(sizeof(proto::SnapshotHeader), cloud.count());
  const auto records = grid.records();
  cloud.write_to(records);
  for (proto::SphereRecord& record : records) {
    collision::fill_history(record, record.newest);
  }
  grid.enter(collision::history_bounds(records), 1.0F);
  return grid;
}

/// Showing a filled snapshot of N moving spheres in the scene segment.
void publish_snapshot(benchmark::State& state) {
  const SphereCloud cloud(static_cast<std::size_t>(state.range(0)));
  publication::StaticScene scene;
  scene.name = "cloud";
  scene.device = {{0, 0, 0}, {0, 0, 0, 1}, 1.0};
  publication::SceneWriter writer("benchmark", scene, cloud.count(), 10'000'000,
                                  proto::Clock::kVirtual, 0);
  const collision::VoxelGrid snapshot = first_snapshot(cloud);
  for (int i = 0; i < 2; ++i) writer.publish(snapshot, {});  // both slots have been touched
  for (auto _ : state) {
    writer.publish(snapshot, {});
    benchmark::ClobberMemory();
  }
}

/// Half a page from the source modulo pages: what lies a little above it there is copied several
/// times as slowly by some processors.
std::uint64_t* apart_from(const std::uint64_t* source, std::uint64_t* target) {
  constexpr std::uintptr_t kPage = 4096;
  const auto distance =
      reinterpret_cast<std::uintptr_t>(target) - reinterpret_cast<std::uintptr_t>(source);
  return target + (kPage + kPage / 2 - distance % kPage) % kPage / sizeof *target;
}

/// As many bytes, by memcpy between private memories: the least that a copy can cost.
void copy_snapshot(benchmark::State& state) {
  const SphereCloud cloud(static_cast<std::size_t>(state.range(0)));
  collision::VoxelGrid grid = first_snapshot(cloud);
  const auto parts = grid.filled_parts();
  constexpr std::size_t kPageWords = 512;
  const std::size_t slot_words = (grid.layout().total_words / kPageWords + 1) * kPageWords;
  std::vector<std::uint64_t> target(2 * slot_words + kPageWords, 1);
  std::uint64_t* const slots = apart_from(grid.words().data(), target.data());
  std::size_t bytes = sizeof(proto::SnapshotHeader), slot = 0;
  for (const double_buffer::PayloadPart& part : parts) bytes += part.words.size_bytes();
  for (auto _ : state) {
    slot = 1 - slot;  // two slots in turn
    std::uint64_t* start = slots + slot * slot_words;
    std::memcpy(start, grid.words().data(), sizeof(proto::SnapshotHeader));
    for (const double_buffer::PayloadPart& part : parts)
      std::memcpy(start + part.first_word, part.words.data(), part.words.size_bytes());
    benchmark::ClobberMemory();
  }
  state.counters["bytes"] = static_cast<double>(bytes);
}

/// From 400 to 400,000 spheres in steps of about two.
void sphere_counts(benchmark::internal::Benchmark* measured) {
  for (const int n : {400, 1000, 2000, 4000, 10000, 20000, 40000, 100000, 200000, 400000})
    measured->Arg(n);
}

BENCHMARK(publish_snapshot)->Name("publish/scene_snapshot")->Apply(sphere_counts);
BENCHMARK(copy_snapshot)->Name("publish/memcpy")->Apply(sphere_counts);

}  // namespace
}  // namespace stillgrid::performance
