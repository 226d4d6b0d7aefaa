#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::soft_solids_test {
namespace {

constexpr double kStep_s = 0.01;

/// A soft cube of 30 mm with its lower face at a height.
bodies::BodyDescription cube_at(double height_m) {
  bodies::BodyDescription body =
      sim_server::soft_block({4, 4, 4}, 0.01, 1e-3, 100.0, {0.006, 0.004});
  sim_server::springs(body).bend_stiffness_N_per_m = 20.0;
  sim_server::springs(body).spring_damping_N_s_per_m = 0.1;
  body.position_m = {0, 0, height_m + 0.015};
  return body;
}

Eigen::Vector3d momentum_N_s(const bodies::World& world) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const bodies::Node& node : world.nodes) sum += node.mass_kg * node.velocity_m_s;
  return sum;
}

Eigen::Vector3d angular_momentum_N_m_s(const bodies::World& world) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const bodies::Node& node : world.nodes)
    sum += node.position_m.cross(node.mass_kg * node.velocity_m_s);
  return sum;
}

TEST_CASE("A soft block falls on the floor, gives way and comes to rest upright", "[soft_solids]") {
  Simulation simulation(sim_server::scene_of({cube_at(0.01), sim_server::floor_at(0.0)},
                                             sim_server::material_of(200.0, 0.5, 0.5),
                                             {0, 0, -9.81}));
  const double start_J = bodies::mechanical_energy_J(simulation.world());
  for (int i = 0; i < 200; ++i) {
    REQUIRE(advance(simulation, kStep_s, 1));
    CHECK(bodies::mechanical_energy_J(simulation.world()) <= start_J + 1e-9);
  }

  double lowest_m = 1.0, highest_m = -1.0, fastest_m_s = 0.0;
  for (const bodies::Node& node : simulation.world().nodes) {
    lowest_m = std::min(lowest_m, node.position_m.z());
    highest_m = std::max(highest_m, node.position_m.z());
    fastest_m_s = std::max(fastest_m_s, node.velocity_m_s.norm());
  }
  CHECK(lowest_m > -0.003);
  CHECK(highest_m - lowest_m > 0.025);
  CHECK(highest_m - lowest_m < 0.03);  // its own weight shortens it
  CHECK(fastest_m_s < 1e-3);
}

TEST_CASE("A soft block that nothing touches keeps its momentum, turning and all",
          "[soft_solids]") {
  bodies::BodyDescription cube =
      sim_server::moving(cube_at(0.0), {0.3, -0.2, 0.1}, {1.0, 2.0, 3.0});
  Simulation simulation(sim_server::scene_of({cube}));
  const Eigen::Vector3d momentum = momentum_N_s(simulation.world());
  CHECK((momentum / cube.mass_kg - cube.velocity_m_s).norm() < 1e-12);
  const Eigen::Vector3d spin = angular_momentum_N_m_s(simulation.world());
  CHECK(advance(simulation, 1e-4, 100));

  // To what the solver leaves: 1e-8 m/s a step.
  CHECK((momentum_N_s(simulation.world()) - momentum).norm() < 100 * 1e-8 * cube.mass_kg);
  CHECK((angular_momentum_N_m_s(simulation.world()) - spin).norm() < 1e-8);
}

TEST_CASE("A pinned part of a soft block stays while the tool presses the other side in",
          "[soft_solids]") {
  bodies::BodyDescription cube = cube_at(0.0);
  for (int i = 0; i < 16; ++i)
    sim_server::springs(cube).pinned_nodes.push_back(i);  // the lowest layer
  scene::SceneDescription scene = sim_server::scene_of({cube}, sim_server::material_of(500.0));
  scene.tool = {{Eigen::Vector3d::Zero(), 0.005}};
  Simulation simulation(scene);
  const bodies::World start = simulation.world();
  const auto press = [] { return ToolSample{.position_m = {0, 0, 0.033}}; };
  int contacts = 0;
  for (int i = 0; i < 100; ++i) contacts = simulation.step(kStep_s, press).contacts;

  CHECK(contacts > 0);
  for (std::size_t i = 0; i < 16; ++i)
    CHECK(simulation.world().nodes[i].position_m == start.nodes[i].position_m);
  const std::size_t top = 53;  // amid the highest layer
  const double sunk_m =
      start.nodes[top].position_m.z() - simulation.world().nodes[top].position_m.z();
  CHECK(sunk_m > 2e-4);
  CHECK(sunk_m < 2e-3);
}

TEST_CASE("A rigid mesh moves as the box whose spheres, mass and inertia it has", "[soft_solids]") {
  bodies::BodyDescription block =
      sim_server::box({0, 0, 0.03}, {0.03, 0.03, 0.02}, 0.02, {0.01, 0.005});
  block.orientation = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 0).normalized());
  const bodies::World plain = scene::build_world(sim_server::scene_of({block}));
  std::vector<spheres::Ball> balls;
  for (const bodies::SphereBinding& sphere : plain.spheres)
    balls.push_back({sphere.local_m, sphere.radius_m});
  bodies::BodyDescription mesh = sim_server::rigid_mesh(
      balls, plain.rigid_bodies[0].inertia_kg_m2 / block.mass_kg, block.mass_kg);
  mesh.position_m = block.position_m;
  mesh.orientation = block.orientation;
  const auto landing = [](const bodies::BodyDescription& body) {
    return sim_server::scene_of({body, sim_server::floor_at(0.0)},
                                sim_server::material_of(500.0, 1.0, 0.3), {0, 0, -9.81});
  };
  Simulation as_box(landing(block)), as_mesh(landing(mesh));
  CHECK(advance(as_box, kStep_s, 40));
  CHECK(advance(as_mesh, kStep_s, 40));

  const bodies::RigidBody &a = as_box.world().rigid_bodies[0], &b = as_mesh.world().rigid_bodies[0];
  CHECK((a.position_m - b.position_m).norm() < 1e-6);
  CHECK(a.orientation.angularDistance(b.orientation) < 1e-4);
}

}  // namespace
}  // namespace stillgrid::dynamics::soft_solids_test
