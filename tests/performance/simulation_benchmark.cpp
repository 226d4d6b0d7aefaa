#include <benchmark/benchmark.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "sim_server/snapshot/moving_snapshot.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::performance {
namespace {

struct RunningScene {
  explicit RunningScene(const scene::SceneDescription& scene)
      : period_s(scene.period_s), simulation(scene) {}
  dynamics::StepReport step() {
    return simulation.step(period_s, [] { return std::nullopt; });
  }
  double period_s;
  dynamics::Simulation simulation;
};

/// A shipped scene after five seconds, when what fell lies; it goes on between benchmarks. Nothing
/// sleeps: the work is to be seen.
RunningScene& settled(const std::string& name) {
  static std::map<std::string, std::unique_ptr<RunningScene>> scenes;
  auto& scene = scenes[name];
  if (!scene) {
    const std::filesystem::path root = STILLGRID_SOURCE_DIR;
    scene::SceneDescription description =
        scene::load_scene(root / "sim_server/scene/scenes" / (name + ".toml"));
    description.sleeping = false;
    scene = std::make_unique<RunningScene>(description);
    while (scene->simulation.world().time_s < 5.0) (void)scene->step();
  }
  return *scene;
}

double seconds(std::chrono::nanoseconds time) {
  return std::chrono::duration<double>(time).count();
}

/// One phase of a whole step: finding contacts, or solving for the motion.
template <class Phase>
void step_phase(benchmark::State& state, const std::string& scene, Phase phase) {
  RunningScene& running = settled(scene);
  double iterations = 0.0, contacts = 0.0;
  for (auto _ : state) {
    const dynamics::StepReport report = running.step();
    state.SetIterationTime(seconds(phase(report)));
    iterations += report.solve.iterations;
    contacts += report.contacts;
  }
  state.counters["iterations"] = benchmark::Counter(iterations, benchmark::Counter::kAvgIterations);
  state.counters["contacts"] = benchmark::Counter(contacts, benchmark::Counter::kAvgIterations);
}

void integrate(benchmark::State& state, const std::string& scene) {
  step_phase(state, scene, [](const dynamics::StepReport& report) { return report.integrate; });
}

/// 400 blocks of 18 spheres that lie on a floor, and one that a prescribed motion waves above them.
scene::SceneDescription lying_blocks(bool sleeping) {
  scene::SceneDescription scene;
  scene.sleeping = sleeping;
  scene.materials = {{"block", 500.0, 1.0, 0.3}};
  const auto add = [&](const bodies::BodyShape& shape, bodies::Motion motion,
                       const Eigen::Vector3d& position_m) {
    bodies::BodyDescription& body = scene.bodies.emplace_back();
    body.name = "block " + std::to_string(scene.bodies.size());
    body.shape = shape;
    body.motion = motion;
    body.position_m = position_m;
    body.mass_kg = 0.02;
  };
  const bodies::RigidBoxBody block{{0.03, 0.03, 0.02}, {0.01, 0.005}};
  add(bodies::PlaneBody{}, bodies::Motion::kStatic, {0, 0, 0});
  for (int i = 0; i < 400; ++i)
    add(block, bodies::Motion::kFree, {0.04 * (i % 20), 0.04 * (i / 20), 0.0099});
  add(block, bodies::Motion::kPrescribed, {0.4, 0.4, 0.05});
  scene.bodies.back().prescribed = {
      .direction = Eigen::Vector3d::UnitX(), .amplitude_m = 0.3, .frequency_hz = 0.5};
  return scene;
}

/// A whole step of them, three seconds after the start.
void step_lying_blocks(benchmark::State& state, bool sleeping) {
  RunningScene running(lying_blocks(sleeping));
  while (running.simulation.world().time_s < 3.0) (void)running.step();
  int is_sleeping = 0;
  for (auto _ : state) is_sleeping = running.step().sleeping_spheres;
  state.counters["is_sleeping"] = is_sleeping;
}
BENCHMARK_CAPTURE(step_lying_blocks, awake, false)
    ->Name("step/lying_blocks/awake")
    ->Unit(benchmark::kMicrosecond)
    ->Iterations(100);
BENCHMARK_CAPTURE(step_lying_blocks, is_sleeping, true)
    ->Name("step/lying_blocks/is_sleeping")
    ->Unit(benchmark::kMicrosecond)
    ->Iterations(1000);

/// Balls in touch with their neighbours in a cube, which stand still, the tool at its top.
scene::SceneDescription still_heap(int balls) {
  const int side = static_cast<int>(std::lround(std::cbrt(balls)));
  std::vector<bodies::BodyDescription> bodies;
  for (int i = 0; i < balls; ++i)
    bodies.push_back(sim_server::sphere(
        {0.0199 * (i % side), 0.0199 * (i / side % side), 0.0199 * (i / (side * side))}, 0.01,
        0.02));
  scene::SceneDescription scene =
      sim_server::scene_of(std::move(bodies), sim_server::material_of(100.0, 1.0));
  scene.period_s = 0.01;
  scene.method.integrator = scene::IntegratorKind::kVelocityVerlet;
  const int layers = (balls - 1) / (side * side);
  scene.device.position_m = {0.0099 * side, 0.0099 * side, 0.0199 * layers + 0.014};
  scene.tool = {{Eigen::Vector3d::Zero(), 0.005}};
  return scene;
}

/// What a step of the product does beside moving the world on: taking the snapshot. Nanoseconds a
/// sphere.
void take_snapshots(benchmark::State& state) {
  const auto balls = static_cast<int>(state.range(0));
  const bodies::World world = scene::build_world(still_heap(balls));
  snapshot::MovingSnapshot snapshot(world, 0.0);
  for (auto _ : state) snapshot.show(world);
  state.counters["ns_a_sphere"] =
      benchmark::Counter(1e-9 * static_cast<double>(state.iterations()) * balls,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(take_snapshots)->Name("beside/show")->Arg(40000);

/// Whole steps, and what they had to do on average.
void take_steps(benchmark::State& state, RunningScene& running) {
  double contacts = 0.0, substeps = 0.0;
  for (auto _ : state) {
    const dynamics::StepReport report = running.step();
    contacts += report.contacts;
    substeps += report.solve.iterations;
  }
  state.counters["substeps"] = benchmark::Counter(substeps, benchmark::Counter::kAvgIterations);
  state.counters["contacts"] = benchmark::Counter(contacts, benchmark::Counter::kAvgIterations);
}

/// A shipped scene at the haptic rate by velocity Verlet, from its second second on: the work of a
/// whole step.
void haptic_rate(benchmark::State& state) {
  const std::filesystem::path root = STILLGRID_SOURCE_DIR;
  scene::SceneDescription description =
      scene::load_scene(root / "sim_server/scene/scenes/tissue_and_blocks.toml");
  description.method.integrator = scene::IntegratorKind::kVelocityVerlet;
  description.period_s = 1e-3;
  description.sleeping = false;
  RunningScene running(description);
  for (int i = 0; i < 1000; ++i) (void)running.step();
  take_steps(state, running);
}
BENCHMARK(haptic_rate)
    ->Name("step/tissue_and_blocks_1kHz")
    ->Iterations(2000)
    ->Unit(benchmark::kMicrosecond);

/// A shipped scene as it is, at its own rate: the work of a whole step.
void as_shipped(benchmark::State& state) {
  take_steps(state, settled("tissue_and_blocks"));
}
BENCHMARK(as_shipped)
    ->Name("step/tissue_and_blocks_as_shipped")
    ->Iterations(200)
    ->Unit(benchmark::kMicrosecond);

/// The same with a tool that stirs in it: what the tool adds is seen.
void stirred(benchmark::State& state, const std::string& name) {
  const std::filesystem::path root = STILLGRID_SOURCE_DIR;
  const scene::SceneDescription description =
      scene::load_scene(root / "sim_server/scene/scenes" / (name + ".toml"));
  dynamics::Simulation simulation(description);
  double contacts = 0.0;
  const auto step = [&] {
    const double t_s = simulation.world().time_s;
    dynamics::ToolSample tool;
    tool.time_ns = 1 + static_cast<std::uint64_t>(1e9 * t_s);
    tool.position_m = description.device.position_m +
                      Eigen::Vector3d(0.02 * std::sin(9.0 * t_s), 0.015 * std::cos(7.0 * t_s),
                                      -0.02 * (1.0 - std::cos(5.0 * t_s)));
    return simulation.step(description.period_s, [&] { return tool; });
  };
  while (simulation.world().time_s < 1.0) (void)step();
  for (auto _ : state) contacts += step().contacts;
  state.counters["contacts"] = benchmark::Counter(contacts, benchmark::Counter::kAvgIterations);
}
BENCHMARK_CAPTURE(stirred, tissue_and_blocks, "tissue_and_blocks")
    ->Name("step_stirred/tissue_and_blocks")
    ->Iterations(500)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(stirred, threads, "threads")
    ->Name("step_stirred/threads")
    ->Iterations(500)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(stirred, organ, "organ")
    ->Name("step_stirred/organ")
    ->Iterations(300)
    ->Unit(benchmark::kMicrosecond);

/// 10 ms of a square cloth of 1 kg and 1 m that hangs by two corners, without contacts.
void swing_cloth(benchmark::State& state) {
  const auto side = static_cast<int>(state.range(0));
  bodies::BodyDescription body =
      sim_server::sheet({side, side}, 1.0 / (side - 1), 1.0 / (side * side), 1e4);
  sim_server::shear_stiffness_N_per_m(body) = 5e3;
  sim_server::springs(body).bend_stiffness_N_per_m = 1e3;
  sim_server::springs(body).pinned_nodes = {0, side - 1};
  scene::SceneDescription scene = sim_server::scene_of({body}, {}, {0.0, 0.0, -9.81});
  scene.method = {.integrator = scene::IntegratorKind::kVelocityVerlet};
  scene.sleeping = false;
  dynamics::Simulation simulation(scene);
  int substeps = 0;
  for (auto _ : state) substeps = simulation.step(0.01, [] { return std::nullopt; }).substeps;
  state.counters["substeps"] = substeps;
}
BENCHMARK(swing_cloth)
    ->Name("cloth_10ms")
    ->Arg(8)
    ->Arg(32)
    ->Arg(100)
    ->Unit(benchmark::kMillisecond);

BENCHMARK_CAPTURE(integrate, tissue, "tissue_and_blocks")
    ->Name("step_integrate/tissue_and_blocks")
    ->UseManualTime()
    ->Iterations(20);
BENCHMARK_CAPTURE(integrate, threads, "threads")
    ->Name("step_integrate/threads")
    ->UseManualTime()
    ->Iterations(50);

}  // namespace
}  // namespace stillgrid::performance
