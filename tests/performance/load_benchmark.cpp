#include <benchmark/benchmark.h>

#include <cmath>
#include <string>

#include "sim_server/contact/start_warnings.hpp"
#include "sim_server/scene/build_world.hpp"
#include "sim_server/scene/scene_file.hpp"

namespace stillgrid::performance {
namespace {

/// Spheres in a cube, each a body and `gap_m` from the next; every second one static, if asked for.
std::string sphere_bodies(int count, double gap_m, bool half_static) {
  std::string text = "format = 2\n[[material]]\nname = \"m\"\ncontact_stiffness_N_per_m = 500.0\n";
  const int side = static_cast<int>(std::lround(std::cbrt(count) + 0.5));
  for (int i = 0; i < count; ++i) {
    const auto at_m = [&](int place) { return std::to_string((0.02 + gap_m) * place); };
    text += "[[body]]\nname = \"ball " + std::to_string(i) +
            "\"\nkind = \"sphere\"\nradius_m = 0.01\nmaterial = \"m\"\nposition_m = [" +
            at_m(i % side) + ", " + at_m(i / side % side) + ", " + at_m(i / side / side) + "]\n" +
            (half_static && i % 2 == 0 ? "motion = \"static\"\n" : "mass_kg = 0.001\n");
  }
  return text;
}

/// From a scene's text to its checked world, as sim_server begins.
void load(benchmark::State& state, double gap_m, bool half_static) {
  const auto count = static_cast<int>(state.range(0));
  const std::string text = sphere_bodies(count, gap_m, half_static);
  for (auto _ : state) {
    const scene::SceneDescription scene = scene::read_scene(text, "scene.toml");
    const bodies::World world = scene::build_world(scene);
    benchmark::DoNotOptimize(contact::start_warnings(scene, world, "scene.toml"));
  }
  state.SetItemsProcessed(state.iterations() * count);
}

void counts(benchmark::internal::Benchmark* benchmark) {
  benchmark->Arg(400)->Arg(4'000)->Arg(40'000)->Unit(benchmark::kMillisecond);
}
BENCHMARK_CAPTURE(load, apart, 0.001, false)->Name("load/sphere_bodies")->Apply(counts);
BENCHMARK_CAPTURE(load, overlap, -0.011, true)->Name("load/overlapping_half_static")->Apply(counts);

}  // namespace
}  // namespace stillgrid::performance
