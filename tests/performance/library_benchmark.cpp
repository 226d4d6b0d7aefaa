#include <benchmark/benchmark.h>
#include <unistd.h>

#include <array>
#include <string>
#include <vector>

#include "proto/stillgrid.h"
#include "shared/publication/scene_segment.hpp"
#include "sim_server/snapshot/moving_snapshot.hpp"
#include "tests/performance/sphere_cloud.hpp"

namespace stillgrid::performance {
namespace {

/// The states of a cloud over some steps, in turn forwards and back.
class Steps {
 public:
  static constexpr std::size_t kSteps = 16;

  explicit Steps(std::size_t count) : cloud_(count) {
    for (std::vector<double>& places_m : places_m_) {
      for (std::size_t i = 0; i < count; ++i)
        for (Eigen::Index axis = 0; axis < 3; ++axis)
          places_m.push_back(cloud_.position_m(i)[axis]);
      cloud_.move();
    }
    for (std::size_t i = 0; i < count; ++i) {
      radii_m_.push_back(double{cloud_.radius_m(i)});
      for (Eigen::Index axis = 0; axis < 3; ++axis)
        velocities_m_s_.push_back(cloud_.velocity_m_s(i)[axis]);
    }
  }
  const std::vector<double>& next() {
    const std::size_t turn = step_++ % (2 * kSteps - 2);
    return places_m_[turn < kSteps ? turn : 2 * kSteps - 2 - turn];
  }
  [[nodiscard]] const std::vector<double>& velocities_m_s() const { return velocities_m_s_; }
  [[nodiscard]] const std::vector<double>& radii_m() const { return radii_m_; }

 private:
  SphereCloud cloud_;
  std::array<std::vector<double>, kSteps> places_m_;
  std::vector<double> velocities_m_s_, radii_m_;
  std::size_t step_ = 0;
};

/// A step's publication by the C ABI: all spheres set, entered in their grid, shown.
void publish_by_c(benchmark::State& state) {
  const auto count = static_cast<std::uint32_t>(state.range(0));
  Steps steps(count);
  const std::string session = "benchmark-c-" + std::to_string(::getpid());
  const stillgrid_material material{500.0, 1.0, 0.3};
  stillgrid_scene scene{};
  scene.struct_size = sizeof scene;
  scene.session = session.c_str();
  scene.period_s = 0.01;
  scene.sphere_capacity = count;
  scene.material_count = 1;
  scene.materials = &material;
  stillgrid_publisher* publisher = nullptr;
  stillgrid_shapes shapes{};
  shapes.struct_size = sizeof shapes;
  shapes.count = count;
  shapes.radii_m = steps.radii_m().data();
  if (stillgrid_publisher_open(&scene, &publisher) != STILLGRID_OK ||
      stillgrid_publisher_set_shapes(publisher, &shapes) != STILLGRID_OK)
    return state.SkipWithError(stillgrid_last_error());
  const auto step = [&] {
    if (stillgrid_publisher_set_spheres(publisher, count, steps.next().data(),
                                        steps.velocities_m_s().data()) != STILLGRID_OK ||
        stillgrid_publisher_publish(publisher, 0) != STILLGRID_OK)
      state.SkipWithError(stillgrid_last_error());
  };
  for (int i = 0; i < 2; ++i) step();  // both slots have been touched
  for (auto _ : state) step();
  stillgrid_publisher_close(publisher);
}

/// The server's own.
void publish_by_server(benchmark::State& state) {
  const auto count = static_cast<std::size_t>(state.range(0));
  Steps steps(count);
  publication::StaticScene fixed;
  fixed.device = {{0, 0, 0}, {0, 0, 0, 1}, 1.0};
  publication::SceneWriter writer("benchmark-server-" + std::to_string(::getpid()), fixed, count,
                                  10'000'000, proto::Clock::kVirtual, 0);
  bodies::World world;
  world.bodies.emplace_back();
  for (std::size_t i = 0; i < count; ++i) {
    bodies::SphereBinding& sphere = world.spheres.emplace_back();
    sphere.radius_m = steps.radii_m()[i];
    sphere.node_count = 1;
    sphere.nodes[0] = static_cast<int>(i);
    sphere.weights[0] = 1.0;
    world.nodes.emplace_back().velocity_m_s =
        Eigen::Vector3d(steps.velocities_m_s().data() + 3 * i);
  }
  const auto move = [&] {
    const std::vector<double>& places_m = steps.next();
    for (std::size_t i = 0; i < count; ++i)
      world.nodes[i].position_m = Eigen::Vector3d(places_m.data() + 3 * i);
  };
  move();
  snapshot::MovingSnapshot snapshot(world, 0.0);
  const auto step = [&] {
    move();
    snapshot.show(world);
    writer.publish(snapshot.grid(), {});
  };
  for (int i = 0; i < 2; ++i) step();
  for (auto _ : state) step();
}

void counts(benchmark::internal::Benchmark* measured) {
  for (const int n : {400, 4000, 40000, 400000}) measured->Arg(n);
}

BENCHMARK(publish_by_c)->Name("publish/c_abi")->Apply(counts)->Unit(benchmark::kMicrosecond);
BENCHMARK(publish_by_server)->Name("publish/server")->Apply(counts)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace stillgrid::performance
