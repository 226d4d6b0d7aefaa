// What a contact with a field costs in a step, beside one with a sphere or a plane.

#include <benchmark/benchmark.h>

#include <chrono>

#include "sim_server/dynamics/step/simulation.hpp"
#include "tests/sim_server/field_worlds.hpp"

namespace stillgrid::performance {
namespace {

constexpr int kAlong = 20;
constexpr double kRadius_m = 0.005, kApart_m = 0.012;

enum class Ground { kPlane, kSpheres, kField };

/// 400 balls that lie each on one contact: on a plane, on a sphere of its own each, on one slab
/// that is a field.
struct Balls {
  scene::SceneDescription scene;
  bodies::World world;
};
Balls balls_on(Ground ground, const scene::IntegratorKind& integrator) {
  std::vector<bodies::BodyDescription> bodies;
  for (int i = 0; i < kAlong * kAlong; ++i)
    bodies.push_back(sim_server::sphere(
        {kApart_m * (i % kAlong), kApart_m * (i / kAlong), 0.99 * kRadius_m}, kRadius_m, 0.005));
  if (ground == Ground::kPlane) bodies.push_back(sim_server::floor_at(0.0));
  if (ground == Ground::kSpheres)
    for (int i = 0; i < kAlong * kAlong; ++i) {
      bodies.push_back(sim_server::sphere(
          {kApart_m * (i % kAlong), kApart_m * (i / kAlong), -kRadius_m}, kRadius_m, 0.0));
      bodies.back().motion = bodies::Motion::kStatic;
    }
  Balls balls{
      sim_server::scene_of(bodies, sim_server::material_of(500.0, 0.5, 0.3), {0.0, 0.0, -9.81}),
      {}};
  balls.scene.method.integrator = integrator;
  balls.world = scene::build_world(balls.scene);
  if (ground == Ground::kField) {
    const Eigen::Vector3d slab_m(0.3, 0.3, 0.02);
    const double middle_m = 0.5 * kApart_m * (kAlong - 1);
    sim_server::add_static_field(balls.world, sim_server::box_field(slab_m, 0.002, 0.01),
                                 {middle_m, middle_m, -0.5 * slab_m.z()});
  }
  return balls;
}

/// Steps of 4 ms: one part, its contacts found once.
void step(benchmark::State& state, Ground ground, const scene::IntegratorKind& integrator) {
  const Balls balls = balls_on(ground, integrator);
  dynamics::Simulation simulation(balls.scene, balls.world);
  const auto go_on = [&] { return simulation.step(0.004, [] { return std::nullopt; }); };
  for (int i = 0; i < 100; ++i) (void)go_on();
  double detect_s = 0.0, solve_s = 0.0, work = 0.0;
  for (auto _ : state) {
    const dynamics::StepReport report = go_on();
    detect_s += std::chrono::duration<double>(report.detect).count();
    solve_s += std::chrono::duration<double>(report.respond + report.integrate).count();
    work += report.contacts * (scene::is_explicit(integrator) ? report.solve.iterations : 1);
  }
  // Nanoseconds a contact: found, and a substep of it, of an implicit method the whole solution.
  const double steps = static_cast<double>(state.iterations()) * kAlong * kAlong;
  state.counters["found_ns"] = 1e9 * detect_s / steps;
  state.counters["substep_ns"] = 1e9 * solve_s / work;
}

using scene::IntegratorKind;
BENCHMARK_CAPTURE(step, balls_on_plane_explicit, Ground::kPlane, IntegratorKind::kVelocityVerlet);
BENCHMARK_CAPTURE(step, balls_on_spheres_explicit, Ground::kSpheres,
                  IntegratorKind::kVelocityVerlet);
BENCHMARK_CAPTURE(step, balls_on_field_explicit, Ground::kField, IntegratorKind::kVelocityVerlet);
BENCHMARK_CAPTURE(step, balls_on_plane_implicit, Ground::kPlane, IntegratorKind::kImplicitEuler);
BENCHMARK_CAPTURE(step, balls_on_spheres_implicit, Ground::kSpheres,
                  IntegratorKind::kImplicitEuler);
BENCHMARK_CAPTURE(step, balls_on_field_implicit, Ground::kField, IntegratorKind::kImplicitEuler);

}  // namespace
}  // namespace stillgrid::performance
