#include <benchmark/benchmark.h>

#include <cstring>

#include "shared/publication/scene_segment.hpp"
#include "tests/performance/sphere_cloud.hpp"

namespace stillgrid {
namespace {

/// Showing a filled image of N moving spheres in the scene segment.
void publish_image(benchmark::State& state) {
  const SphereCloud cloud(static_cast<std::size_t>(state.range(0)));
  StaticScene scene;
  scene.name = "cloud";
  scene.device = {{0, 0, 0}, {0, 0, 0, 1}, 1.0};
  SceneWriter writer("benchmark", scene, cloud.count(), 10'000'000, proto::Clock::kVirtual, 0);
  for (std::size_t i = 0; i < cloud.count(); ++i) {
    writer.describe_sphere(i, static_cast<float>(SphereCloud::kRadius_m), 0, 0);
    writer.set_sphere(i, cloud.position_m(i), cloud.velocity_m_s(i));
  }
  writer.fill(SphereCloud::voxel_m());
  for (int i = 0; i < 2; ++i) writer.publish({});  // both slots have been touched
  for (auto _ : state) {
    writer.publish({});
    benchmark::ClobberMemory();
  }
}

/// As many bytes, by memcpy between private memories: the least that a copy can cost.
void copy_image(benchmark::State& state) {
  const SphereCloud cloud(static_cast<std::size_t>(state.range(0)));
  StillGrid grid(sizeof(proto::SnapshotHeader), cloud.count());
  const auto records = grid.records();
  cloud.write_to(records);
  for (proto::SphereRecord& record : records) {  // one image only, as a first publication has
    record.newest[1] = record.newest[0];
    record.older = record.newest;
  }
  grid.fill(cloud.count(), SphereCloud::voxel_m());
  const auto parts = grid.filled_parts();
  std::vector<std::uint64_t> target(2 * grid.layout().total_words, 1);
  std::size_t bytes = sizeof(proto::SnapshotHeader), slot = 0;
  for (const PayloadPart& part : parts) bytes += part.words.size_bytes();
  for (auto _ : state) {
    slot = 1 - slot;  // two slots in turn
    std::uint64_t* start = target.data() + slot * grid.layout().total_words;
    std::memcpy(start, grid.words().data(), sizeof(proto::SnapshotHeader));
    for (const PayloadPart& part : parts)
      std::memcpy(start + part.first_word, part.words.data(), part.words.size_bytes());
    benchmark::ClobberMemory();
  }
  state.counters["bytes"] = static_cast<double>(bytes);
}

BENCHMARK(publish_image)->Name("publish/scene_image")->Arg(400)->Arg(4000)->Arg(40000);
BENCHMARK(copy_image)->Name("publish/memcpy")->Arg(400)->Arg(4000)->Arg(40000);

}  // namespace
}  // namespace stillgrid
