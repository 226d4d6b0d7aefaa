// Runs that are not to be trusted end, and runs that are do not.
#include "sim_server/dynamics/step/energy_watch.hpp"

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <variant>

#include "shared/dynamics/spectrum_bound.hpp"
#include "shared/realtime/flush_denormals.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/dynamics/ticks/described_world.hpp"
#include "sim_server/scene/build_world.hpp"
#include "tests/sim_server/dynamics/spring_matrix.hpp"
#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::energy_watch_test {
namespace {

bodies::BodyDescription block_of(const Eigen::Vector3i& nodes, const Eigen::Vector3d& size_m) {
  bodies::BodyDescription block =
      sim_server::soft_block(nodes, 0.02, 0.03 / nodes.prod(), 85.0, {});
  auto& shape = std::get<bodies::SoftBlockBody>(block.shape);
  shape.size_m = size_m;
  shape.lattice = bodies::block_lattice(size_m, nodes);
  shape.spheres = {0.02, 0.008};
  shape.springs.shear_stiffness_N_per_m = 181.0;
  shape.springs.bend_stiffness_N_per_m = 4.0;
  return block;
}

/// A soft block above a floor, as the one that went from 0.247 J to 285,000 J.
scene::SceneDescription dropped_block(int substeps) {
  bodies::BodyDescription block = block_of({3, 2, 3}, {0.041, 0.074, 0.033});
  block.position_m = {0.0, 0.0, 0.84};
  scene::SceneDescription scene =
      sim_server::scene_of({sim_server::floor_at(0.0), block},
                           sim_server::material_of(5192.0, 0.0, 0.451), {0, 0, -9.81});
  scene.method = {.integrator = scene::IntegratorKind::kVelocityVerlet, .substeps = substeps};
  return scene;
}

TEST_CASE("A soft block that drops gains no energy, and by too few substeps its run ends",
          "[energy_watch]") {
  Simulation steady(dropped_block(0)), wild(dropped_block(2));
  steady.watch_energy();
  wild.watch_energy();
  steady.account_energy();
  CHECK_NOTHROW(advance(steady, 0.01, 200));
  CHECK(steady.energy_account()->end.total_J() < steady.energy_account()->start.total_J());
  CHECK_THROWS_AS(advance(wild, 0.01, 200), std::domain_error);
}

TEST_CASE("Energy that a source gave is no gain, energy without one is", "[energy_watch]") {
  bodies::World world = scene::build_world(sim_server::scene_of(
      {sim_server::moving(sim_server::sphere({0, 0, 0}, 0.01, 0.1), {1.0, 0, 0})}));
  EnergyWatch without(energies_without_contacts(world)), given = without;
  world.rigid_bodies[0].velocity_m_s.x() = 2.0;
  given.note_given(0.15);
  CHECK_THROWS_WITH(without.judge(world, energies_without_contacts(world)),
                    Catch::Contains("0.15 J without a source"));
  CHECK_NOTHROW(given.judge(world, energies_without_contacts(world)));
}

/// A box of 20 g welded to a ball that swings by 20 mm, eight times a second.
scene::SceneDescription welded_to_a_swing(scene::IntegratorKind integrator) {
  bodies::BodyDescription lead = sim_server::sphere({0, 0, 0.1}, 0.01, 0.1);
  lead.motion = bodies::Motion::kPrescribed;
  lead.prescribed.amplitude_m = 0.02;
  lead.prescribed.frequency_hz = 8.0;
  lead.prescribed.direction = Eigen::Vector3d::UnitX();
  scene::SceneDescription scene =
      sim_server::scene_of({lead, sim_server::box({0, 0, 0.05}, {0.02, 0.02, 0.02}, 0.02, {})},
                           sim_server::material_of(1000.0), {0, 0, -9.81});
  scene.joints.push_back({.name = "weld",
                          .body_a = 1,
                          .body_b = 0,
                          .points_m = {{0.005, 0, 0.06}, {0, 0.005, 0.06}, {-0.005, 0, 0.06}},
                          .stiffness_N_per_m = 20000.0,
                          .damping_N_s_per_m = 60.0});
  scene.method.integrator = integrator;
  return scene;
}

TEST_CASE("What a damped joint takes from a body that is led is no gain", "[energy_watch]") {
  const auto integrator =
      GENERATE(scene::IntegratorKind::kImplicitEuler, scene::IntegratorKind::kCvodeBdf);
  Simulation simulation(welded_to_a_swing(integrator));
  simulation.watch_energy();
  CHECK_NOTHROW(advance(simulation, 0.01, 100));
}

TEST_CASE("What a hand gives is no gain", "[energy_watch]") {
  scene::SceneDescription scene = sim_server::scene_of({sim_server::sphere({0, 0, 0}, 0.01, 0.1)},
                                                       sim_server::material_of(500.0), {0, 0, 0});
  scene.tool = {{Eigen::Vector3d::Zero(), 0.01}};
  scene.method = {.integrator = GENERATE(scene::IntegratorKind::kVelocityVerlet,
                                         scene::IntegratorKind::kImplicitEuler)};
  Simulation simulation(scene);
  simulation.watch_energy();
  for (std::uint64_t i = 1; i <= 2000; ++i) {
    const double x_m = -0.03 + 0.02 * std::sin(0.01 * static_cast<double>(i));
    (void)simulation.step(1e-3, [&] {
      return ToolSample{.time_ns = i * 1'000'000, .position_m = {x_m, 0, 0}};
    });
  }
  CHECK(bodies::mechanical_energy_J(simulation.world()) > 0.0);
}

TEST_CASE("A state that is not finite ends the run", "[energy_watch]") {
  scene::SceneDescription scene = sim_server::scene_of({sim_server::sphere({0, 0, 0}, 0.01, 0.1)});
  scene.method = {.integrator = GENERATE(scene::IntegratorKind::kVelocityVerlet,
                                         scene::IntegratorKind::kImplicitEuler)};
  Simulation simulation(scene);
  CHECK(advance(simulation, 0.01, 3));
  simulation.world().gravity_m_s2.x() = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(advance(simulation, 0.01, 1), Catch::Contains("is not finite"));
  CHECK(simulation.world().rigid_bodies[0].position_m.allFinite());
}

double stiffest_per_s2(const bodies::World& world) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(spring_matrix_per_s2(world),
                                                        Eigen::EigenvaluesOnly)
      .eigenvalues()
      .maxCoeff();
}

TEST_CASE("The bound of springs is above their stiffest mode, however they deform",
          "[energy_watch]") {
  const double shake_m = GENERATE(0.0, 0.005, 0.02, 0.1);
  bodies::BodyDescription body = block_of({3, 3, 2}, {0.04, 0.05, 0.03});
  sim_server::springs(body).pinned_nodes = {0, 2};
  bodies::World world = scene::build_world(sim_server::scene_of({body}));
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shake(-1.0, 1.0), heavier(0.3, 3.0);
  for (bodies::Node& node : world.nodes) {
    if (shake_m > 0.0) node.mass_kg *= heavier(random);
    if (!node.pinned)
      node.position_m += shake_m * Eigen::Vector3d(shake(random), shake(random), shake(random));
  }
  const double bound_per_s2 =
      spring_bound(described_without_spheres(world).description).stiffness_per_s2;
  CHECK(stiffest_per_s2(world) <= bound_per_s2);
  if (shake_m == 0.0) CHECK(stiffest_per_s2(world) > 0.25 * bound_per_s2);
}

TEST_CASE("Numbers too small to be normal are zero while they are flushed", "[flush_denormals]") {
  volatile double least = std::numeric_limits<double>::min();
  CHECK(0.5 * least > 0.0);
  {
    const realtime::FlushDenormals flush;
    CHECK(0.5 * least == 0.0);
  }
  CHECK(0.5 * least > 0.0);
}

TEST_CASE("A step leaves no velocity that is too small to be normal", "[flush_denormals]") {
  scene::SceneDescription scene =
      sim_server::scene_of({sim_server::thread(2, {0, 0, 0}, {0.1, 0, 0}, 0.01, 10.0, {0})},
                           sim_server::material_of(500.0), {0, 0, 0});
  scene.method = {.integrator = scene::IntegratorKind::kVelocityVerlet};
  scene.sleeping = false;
  Simulation simulation(scene);
  simulation.world().nodes[1].velocity_m_s.y() = 0.5 * std::numeric_limits<double>::min();
  (void)advance(simulation, 1e-3, 1);
  CHECK(simulation.world().nodes[1].velocity_m_s.y() == 0.0);
}

}  // namespace
}  // namespace stillgrid::dynamics::energy_watch_test
