// The engine of both processes beside Bullet and MuJoCo: time, with the accuracy that it bought.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <functional>

#include "shared/dynamics/implicit_step.hpp"
#include "sim_server/dynamics/ticks/described_world.hpp"
#include "tests/performance/engine_peers.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::performance {
namespace {

using Maker = std::function<std::unique_ptr<PeerWorld>(const PeerScene&)>;
constexpr int kSteps = 50;  // of 10 ms: those of the fall, those of a swing

Maker ours(int threads = 1, const dynamics::EngineMethod& method = {}) {
  return [=](const PeerScene& scene) { return our_world(scene, threads, method); };
}
Maker bullet(const BulletMethod& method) {
  return [=](const PeerScene& scene) { return bullet_world(scene, method); };
}
Maker mujoco(const MujocoMethod& method) {
  return [=](const PeerScene& scene) { return mujoco_world(scene, method); };
}

benchmark::Counter time_per(double count) {
  return {count, benchmark::Counter::kIsRate | benchmark::Counter::kInvert};
}

/// A pile, half a second after its start. Each repetition continues it.
struct Pile {
  PeerScene scene;
  std::unique_ptr<PeerWorld> world;
};

/// Counters: time per body and 10 ms, mean overlap, mean height of the bodies' centres.
void pile(benchmark::State& state, Pile& pile, PeerScene (*scene)(int), int count,
          const Maker& make) {
  if (!pile.world) {
    pile.scene = scene(count);
    pile.world = make(pile.scene);
    for (int i = 0; i < kSteps; ++i) pile.world->step();
  }
  for (auto _ : state) pile.world->step();
  state.counters["per_body"] = time_per(count * static_cast<double>(state.iterations()));
  const std::vector<Pose> poses = pile.world->poses();
  state.counters["overlap_mm"] = overlap_mm(pile.scene, poses);
  state.counters["spheres"] = static_cast<double>(pile.scene.ours.description.spheres.size());
  double height_m = 0.0;
  for (const Pose& pose : poses) height_m += pose.position_m.z() / count;
  state.counters["height_mm"] = 1e3 * height_m;
}

benchmark::internal::Benchmark* add_pile(const std::string& name, PeerScene (*scene)(int),
                                         int count, const Maker& make) {
  const bool is_large = count > (scene == falling_boxes ? 400 : 4'000);
  return benchmark::RegisterBenchmark(
             (name + '/' + std::to_string(count)).c_str(),
             [=, kept = std::make_shared<Pile>()](benchmark::State& state) {
               pile(state, *kept, scene, count, make);
             })
      ->Iterations(is_large ? 2 : 10)
      ->Unit(benchmark::kMillisecond);
}

PeerScene falling_balls(int count) {
  return {dynamics::falling_pile(count), {}};
}

std::string name_of(const BulletMethod& method) {
  return "/bullet_" + std::to_string(method.substeps) + 'x' + std::to_string(method.iterations);
}

void add_piles() {
  for (const int count : {400, 4'000, 40'000}) {
    add_pile("balls/ours", falling_balls, count, ours());
    add_pile("balls/ours_two_threads", falling_balls, count, ours(2))->UseRealTime();
    for (const BulletMethod& method : {BulletMethod{1, 10}, {3, 10}})
      add_pile("balls" + name_of(method), falling_balls, count, bullet(method));
  }
  for (const int count : {400, 4'000}) {
    add_pile("boxes/ours", falling_boxes, count, ours());
    for (const BulletMethod& method : {BulletMethod{1, 10}, {4, 6}, {10, 10}})
      add_pile("boxes" + name_of(method), falling_boxes, count, bullet(method));
  }
  // Its other solvers take longer here. It refuses 2,000 bodies ("could not create mjData").
  for (const MujocoMethod& method :
       {MujocoMethod{1, 0.02, "Euler", "CG"}, {2, 0.014, "Euler", "CG"}}) {
    const std::string name = "/mujoco_" + std::to_string(method.substeps);
    add_pile("balls" + name, falling_balls, 400, mujoco(method));
    add_pile("boxes" + name, falling_boxes, 400, mujoco(method));
  }
}

double mean_gap_mm(const PeerScene& scene, const std::vector<Pose>& poses) {
  const auto place_m = [&](const dynamics::Description::JointEnd& end) -> Eigen::Vector3d {
    if (end.rigid < 0) return end.point_m;
    const Pose& pose = poses[static_cast<std::size_t>(end.rigid)];
    return pose.position_m + pose.orientation * end.point_m;
  };
  double sum_m = 0.0;
  for (const auto& joint : scene.ours.description.joints)
    sum_m += (place_m(joint.a) - place_m(joint.b)).norm();
  return 1e3 * sum_m / static_cast<double>(scene.ours.description.joints.size());
}

/// Returns the poses after half a second: rigid joints, Runge-Kutta of order 4 in steps of 0.1 ms.
const std::vector<Pose>& exact_swing(const PeerScene& scene) {
  static const std::vector<Pose> poses = [&] {
    const auto world = mujoco_world(scene, {.substeps = 100, .integrator = "RK4"});
    for (int i = 0; i < kSteps; ++i) world->step();
    return world->poses();
  }();
  return poses;
}

/// Counters: mean gap of joints, and rms error of positions, after half a second.
void chain(benchmark::State& state, double stiffness_N_per_m, const Maker& make) {
  const PeerScene scene = hanging_links(100, stiffness_N_per_m);
  const auto world = make(scene);
  for (auto _ : state) world->step();
  const std::vector<Pose> poses = world->poses();
  const std::vector<Pose>& exact = exact_swing(scene);
  double squares_m2 = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i)
    squares_m2 += (poses[i].position_m - exact[i].position_m).squaredNorm();
  state.counters["gap_mm"] = mean_gap_mm(scene, poses);
  state.counters["error_mm"] = 1e3 * std::sqrt(squares_m2 / static_cast<double>(poses.size()));
}

void add_chain(const std::string& name, double stiffness_N_per_m, const Maker& make) {
  benchmark::RegisterBenchmark(
      ("chain/" + name).c_str(),
      [=](benchmark::State& state) { chain(state, stiffness_N_per_m, make); })
      ->Iterations(kSteps)
      ->Unit(benchmark::kMicrosecond);
}

void add_chains() {
  add_chain("ours_20000_N_per_m", 2e4, ours());
  for (const int stiffness_N_per_m : {20'000, 100'000, 1'000'000})
    add_chain("ours_implicit_" + std::to_string(stiffness_N_per_m) + "_N_per_m", stiffness_N_per_m,
              ours(1, dynamics::implicit_euler()));
  for (const BulletMethod& method : {BulletMethod{1, 10}, {10, 10}, {10, 100}})
    add_chain(name_of(method).substr(1), 1.0, bullet(method));
  add_chain("mujoco_5", 1.0, mujoco({}));
  add_chain("mujoco_10", 1.0, mujoco({.substeps = 10}));
}

/// Eight soft blocks of 5 x 5 x 10 nodes, four on four, as those of the scene "pillars".
dynamics::DescribedWorld soft_blocks(double spacing_m, double radius_m) {
  std::vector<bodies::BodyDescription> bodies{sim_server::floor_at(0.0)};
  for (int i = 0; i < 8; ++i) {
    const bool is_below = i < 4;
    bodies.push_back(
        sim_server::soft_block(is_below ? Eigen::Vector3i(5, 10, 5) : Eigen::Vector3i(10, 5, 5),
                               0.02, 1.56e-3, 300.0, {spacing_m, radius_m}));
    sim_server::springs(bodies.back()).spring_damping_N_s_per_m = 0.5;
    bodies.back().position_m =
        is_below ? Eigen::Vector3d(0.081 * i - 0.1215, 0.0, 0.04)
                 : Eigen::Vector3d(0.0905 * (2 * (i % 2) - 1), 0.0405 * (2 * (i / 6) - 1), 0.121);
  }
  return dynamics::described(
      scene::build_world(sim_server::scene_of(
          std::move(bodies), sim_server::material_of(500.0, 2.0, 0.4), {0.0, 0.0, -9.81})),
      {}, false);
}

/// A tick of 1 ms, half a second after the start. Each repetition continues by 0.1 s.
void neighbourhood(benchmark::State& state, dynamics::Engine& engine) {
  while (engine.state().tick < 500) engine.step();
  for (auto _ : state) engine.step();
  state.counters["substeps"] = engine.substeps();
  state.counters["touching"] = engine.touching();
  state.counters["spheres"] = static_cast<double>(engine.description().spheres.size());
}

void add_neighbourhood(const std::string& name, dynamics::Description description,
                       dynamics::SceneState scene) {
  benchmark::RegisterBenchmark(
      ("neighbourhood/" + name).c_str(),
      [kept = std::make_shared<dynamics::Engine>(std::move(description), std::move(scene))](
          benchmark::State& state) { neighbourhood(state, *kept); })
      ->Iterations(100)
      ->Unit(benchmark::kMicrosecond);
}

void add_neighbourhoods() {
  dynamics::EngineScene balls = dynamics::falling_pile(2000);
  add_neighbourhood("2000_balls", balls.description, balls.state);
  dynamics::DescribedWorld soft = soft_blocks(0.02, 0.012);
  add_neighbourhood("2000_nodes", soft.description, soft.state);
  soft = soft_blocks(0.01, 0.006);
  add_neighbourhood("2000_nodes_fine_cover", soft.description, soft.state);
}

/// The state that a snapshot carries, with its hash, of a pile that has begun to fall together.
void save_state(benchmark::State& state) {
  const auto balls = static_cast<int>(state.range(0));
  dynamics::EngineScene pile = dynamics::falling_pile(balls);
  dynamics::Engine engine(std::move(pile.description), std::move(pile.state));
  while (engine.state().tick < 50) engine.step();
  std::vector<std::byte> block;
  for (auto _ : state) {
    engine.save(block);
    benchmark::DoNotOptimize(dynamics::hash(engine.state()));
  }
  state.counters["bytes_per_ball"] = static_cast<double>(block.size()) / balls;
}
BENCHMARK(save_state)
    ->Name("save_state")
    ->RangeMultiplier(10)
    ->Range(400, 400'000)
    ->Unit(benchmark::kMicrosecond);

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

int main(int argc, char** argv) {
  stillgrid::performance::add_piles();
  stillgrid::performance::add_chains();
  stillgrid::performance::add_neighbourhoods();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
