// What stands and what falls, through the whole simulation.

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::standing_test {
namespace {

using Eigen::Vector3d;

scene::IntegratorKind explicit_or_default() {
  return GENERATE(scene::IntegratorKind::kVelocityVerlet, scene::IntegratorKind::kImplicitEuler);
}

scene::SceneDescription column_of(int blocks, double stiffness_N_per_m, double damping_N_s_per_m,
                                  double off_m) {
  std::vector<bodies::BodyDescription> bodies{sim_server::floor_at(0.0)};
  for (int i = 0; i < blocks; ++i)
    bodies.push_back(sim_server::box({(i % 2) * off_m, 0, (i + 0.5) * 0.03},
                                     Vector3d::Constant(0.03), 0.1, {0.02, 0.005}));
  scene::SceneDescription scene = sim_server::scene_of(
      bodies, sim_server::material_of(stiffness_N_per_m, damping_N_s_per_m, 0.5), {0, 0, -9.81});
  scene.method.integrator = explicit_or_default();
  return scene;
}

double farthest_aside_m(const bodies::World& world, const std::vector<Vector3d>& from_m) {
  double most_m = 0.0;
  for (std::size_t i = 0; i < from_m.size(); ++i)
    most_m = std::max(most_m, (world.rigid_bodies[i].position_m - from_m[i]).head<2>().norm());
  return most_m;
}

TEST_CASE("Nine blocks, each 0.15 mm off, stand for a minute", "[standing]") {
  Simulation simulation(column_of(9, 24000.0, 5.0, 0.15e-3));
  std::vector<Vector3d> start_m;
  for (const bodies::RigidBody& body : simulation.world().rigid_bodies)
    start_m.push_back(body.position_m);

  REQUIRE(advance(simulation, 0.01, 6000 / kCut));

  CHECK(farthest_aside_m(simulation.world(), start_m) < 0.2e-3);
}

TEST_CASE("Ten blocks that are too soft for their height fall", "[standing]") {
  Simulation simulation(column_of(10, 1250.0, 5.0, 0.15e-3));

  REQUIRE(advance(simulation, 0.01, 2000));

  CHECK(farthest_aside_m(simulation.world(), std::vector<Vector3d>(10, Vector3d::Zero())) > 0.05);
}

TEST_CASE("A block on a slope below its friction angle lies still for a minute", "[standing]") {
  const double angle_deg = GENERATE(10.0, 16.5), step_s = GENERATE(1e-3, 0.01, 0.03);
  const double angle = angle_deg * std::numbers::pi / 180.0;
  scene::SceneDescription scene =
      sim_server::scene_of({sim_server::box({0, 0, 0.01}, {0.06, 0.06, 0.02}, 0.1, {0.05, 0.005}),
                            sim_server::floor_at(0.0)},
                           sim_server::material_of(500.0, 2.0, 0.3),
                           9.81 * Vector3d(std::sin(angle), 0, -std::cos(angle)));
  scene.method.integrator = explicit_or_default();
  Simulation simulation(scene);
  REQUIRE(advance(simulation, step_s, static_cast<int>(5.0 / step_s)));
  const Vector3d at_m = simulation.world().rigid_bodies[0].position_m;

  REQUIRE(advance(simulation, step_s, static_cast<int>(60.0 / step_s)));

  // Implicit Euler solves to 1e-8 m/s, which would allow 0.6 um.
  CHECK((simulation.world().rigid_bodies[0].position_m - at_m).norm() < 2e-7);
}

}  // namespace
}  // namespace stillgrid::dynamics::standing_test
