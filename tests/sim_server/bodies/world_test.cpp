#include "sim_server/bodies/world.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::bodies::world_test {
namespace {

TEST_CASE("Nodes share the mass of their body equally", "[world]") {
  const World world =
      scene::build_world(sim_server::scene_of({sim_server::sheet({8, 8}, 0.02, 0.002, 500.0)}));

  REQUIRE(world.nodes.size() == 64);
  for (const Node& node : world.nodes) CHECK(node.mass_kg == Approx(0.002).epsilon(1e-15));
}

TEST_CASE("An 8x8 sheet has 112 structural springs, and 306 with shear and bend", "[world]") {
  BodyDescription body = sim_server::sheet({8, 8}, 0.02, 0.002, 500.0);
  CHECK(scene::build_world(sim_server::scene_of({body})).springs.size() == 112);
  sim_server::shear_stiffness_N_per_m(body) = 250.0;
  sim_server::springs(body).bend_stiffness_N_per_m = 100.0;
  const World world = scene::build_world(sim_server::scene_of({body}));

  REQUIRE(world.springs.size() == 306);
  std::set<std::pair<int, int>> pairs;
  for (const Spring& spring : world.springs) {
    pairs.insert(std::minmax(spring.a, spring.b));
    const double length_m = (world.nodes[static_cast<std::size_t>(spring.a)].position_m -
                             world.nodes[static_cast<std::size_t>(spring.b)].position_m)
                                .norm();
    CHECK(spring.rest_length_m == Approx(length_m).epsilon(1e-15));
    const double spacings = length_m / 0.02;
    const bool is_known_kind =
        (spring.stiffness_N_per_m == 500.0 && spacings == Approx(1.0)) ||
        (spring.stiffness_N_per_m == 250.0 && spacings == Approx(std::sqrt(2.0))) ||
        (spring.stiffness_N_per_m == 100.0 && spacings == Approx(2.0));
    CHECK(is_known_kind);
  }
  CHECK(pairs.size() == 306);  // no pair twice
}

TEST_CASE("A thread of n nodes has n - 1 springs, and n - 2 more against bending", "[world]") {
  BodyDescription body = sim_server::thread(10, {0, 0, 0}, {0.09, 0, 0}, 0.001, 200.0);
  CHECK(scene::build_world(sim_server::scene_of({body})).springs.size() == 9);
  sim_server::springs(body).bend_stiffness_N_per_m = 5.0;
  CHECK(scene::build_world(sim_server::scene_of({body})).springs.size() == 17);
}

TEST_CASE("A pinned node does not move", "[world]") {
  const World world = scene::build_world(sim_server::scene_of({sim_server::moving(
      sim_server::thread(4, {0, 0, 0}, {0.3, 0, 0}, 0.1, 10.0, {0, 2}), {1, 2, 3})}));

  for (const std::size_t pinned : {0U, 2U}) {
    CHECK(world.nodes[pinned].pinned);
    CHECK(world.nodes[pinned].velocity_m_s.isZero(0.0));
  }
  CHECK_FALSE(world.nodes[1].pinned);
  CHECK_FALSE(world.nodes[3].pinned);
  CHECK(world.nodes[3].velocity_m_s == Eigen::Vector3d(1, 2, 3));
}

TEST_CASE("A spinning sheet or thread starts as a rigid body would", "[world]") {
  BodyDescription cloth = sim_server::sheet({5, 4}, 0.02, 0.002, 500.0);
  cloth.position_m = {1.0, 2.0, 3.0};
  cloth.orientation = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX());
  // A thread's midpoint is told by its ends, whatever its position says.
  BodyDescription rope = sim_server::thread(5, {1, 0, 0}, {3, 4, 0}, 0.1, 10.0);
  rope.position_m.setZero();
  const Eigen::Vector3d velocity_m_s(0.1, 0.2, 0.3), spin_rad_s(4.0, -5.0, 6.0);
  const auto [body, centre_m] = GENERATE_COPY(std::pair(cloth, Eigen::Vector3d(1, 2, 3)),
                                              std::pair(rope, Eigen::Vector3d(2, 2, 0)));
  const World world = scene::build_world(
      sim_server::scene_of({sim_server::moving(body, velocity_m_s, spin_rad_s)}));

  for (const Node& node : world.nodes) {
    const Eigen::Vector3d expected_m_s =
        velocity_m_s + spin_rad_s.cross(node.position_m - centre_m);
    CHECK((node.velocity_m_s - expected_m_s).norm() < 1e-14);
  }
  for (const Spring& spring : world.springs) {  // nothing is stretched by it
    const Node& a = world.nodes[static_cast<std::size_t>(spring.a)];
    const Node& b = world.nodes[static_cast<std::size_t>(spring.b)];
    CHECK(std::abs((b.position_m - a.position_m).dot(b.velocity_m_s - a.velocity_m_s)) < 1e-13);
  }
}

TEST_CASE("Box and ball have the inertia of the textbook", "[world]") {
  const World world = scene::build_world(
      sim_server::scene_of({sim_server::box({0, 0, 0}, {1, 2, 3}, 12.0, {1.0, 0.5}),
                            sim_server::sphere({9, 0, 0}, 0.5, 10.0)}));

  CHECK((world.rigid_bodies[0].inertia_kg_m2 - Eigen::Vector3d(13, 10, 5)).norm() < 1e-14);
  CHECK((world.rigid_bodies[1].inertia_kg_m2 - Eigen::Vector3d(1, 1, 1)).norm() < 1e-14);
}

TEST_CASE("What is static is static spheres and planes, nothing to solve", "[world]") {
  BodyDescription wall = sim_server::box({0, 0, 0.5}, {0.2, 0.2, 0.2}, 0.0, {0.1, 0.05});
  wall.motion = Motion::kStatic;
  BodyDescription net = sim_server::sheet({3, 3}, 0.1, 0.0, 0.0);
  net.motion = Motion::kStatic;
  const World world =
      scene::build_world(sim_server::scene_of({sim_server::floor_at(-0.25), wall, net}));

  CHECK(world.nodes.empty());
  CHECK(world.rigid_bodies.empty());
  CHECK(world.spheres.empty());
  CHECK(world.static_spheres.size() == 8 + 9);
  REQUIRE(world.planes.size() == 1);
  CHECK(world.planes[0].offset_m == -0.25);
  CHECK(world.bodies.size() == 3);
}

TEST_CASE("Spheres know their body, its nodes and its material", "[world]") {
  scene::SceneDescription scene =
      sim_server::scene_of({sim_server::thread(3, {0, 0, 0}, {1, 0, 0}, 0.1, 10.0),
                            sim_server::thread(3, {0, 1, 0}, {1, 1, 0}, 0.1, 10.0),
                            sim_server::sphere({0, 0, 5}, 0.1, 1.0)});
  scene.materials.push_back(sim_server::material_of(700.0));
  scene.bodies[1].material = 1;
  const World world = scene::build_world(scene);

  REQUIRE(world.spheres.size() == 7);
  CHECK(world.spheres[4].body == 1);
  CHECK(world.spheres[4].material == 1);
  CHECK(world.spheres[4].nodes[0] == 4);
  CHECK(world.spheres[6].rigid == 0);
  CHECK(world.bodies[1].first_node == 3);
  CHECK(world.bodies[2].rigid == 0);
}

TEST_CASE("A body whose stiffness is scaled has a material of its own, others keep theirs",
          "[world]") {
  BodyDescription scaled = sim_server::sphere({0, 0, 0}, 0.1, 1.0);
  scaled.stiffness_scale = 0.25;
  BodyDescription still = scaled;
  still.motion = Motion::kStatic;
  const World world = scene::build_world(
      sim_server::scene_of({sim_server::sphere({1, 0, 0}, 0.1, 1.0), scaled, still},
                           sim_server::material_of(400.0, 8.0, 0.3)));

  REQUIRE(world.materials.size() == 3);
  CHECK(world.spheres[0].material == 0);
  CHECK(world.spheres[1].material == 1);
  CHECK(world.static_spheres[0].material == 2);
  CHECK(world.materials[0].stiffness_N_per_m == 400.0);
  for (std::size_t i = 1; i < 3; ++i) {
    CHECK(world.materials[i].stiffness_N_per_m == 100.0);
    CHECK(world.materials[i].damping_N_s_per_m == 2.0);
    CHECK(world.materials[i].friction == 0.3);
  }
}

TEST_CASE("A soft solid has a node at each corner of its lattice and a spring for each link",
          "[world]") {
  BodyDescription body = sim_server::soft_block({3, 2, 2}, 0.1, 0.01, 50.0, {0.05, 0.02});
  sim_server::springs(body).bend_stiffness_N_per_m = 5.0;
  body.position_m = {1, 2, 3};
  body.orientation = Eigen::AngleAxisd(0.5 * 3.14159265358979, Eigen::Vector3d::UnitZ());
  sim_server::springs(body).pinned_nodes = {0};
  body.velocity_m_s = {0, 0, 1};
  const World world = scene::build_world(sim_server::scene_of({body}));

  REQUIRE(world.nodes.size() == 12);
  CHECK(world.nodes[2].position_m.isApprox(Eigen::Vector3d(1.05, 2.1, 2.95)));  // turned corner
  CHECK(world.nodes[0].pinned);
  CHECK(world.nodes[0].velocity_m_s.isZero(0.0));
  CHECK(world.nodes[1].velocity_m_s == Eigen::Vector3d(0, 0, 1));
  CHECK(world.nodes[1].mass_kg == Approx(0.01));
  REQUIRE(world.springs.size() == lattice_springs(*lattice_of(body)).size());
  for (const Spring& spring : world.springs) {
    const double edges = spring.rest_length_m / 0.1;
    const double expected_N_per_m = edges < 1.1 ? 50.0 : edges < 1.9 ? 25.0 : 5.0;
    CHECK(spring.stiffness_N_per_m == expected_N_per_m);
  }
}

TEST_CASE("A prescribed velocity is the derivative of the prescribed position", "[world]") {
  BodyDescription driven = sim_server::sphere({1, 2, 3}, 0.1, 0.0);
  driven.motion = Motion::kPrescribed;
  driven.prescribed = GENERATE(
      PrescribedMotion{.velocity_m_s = 0.3 * Eigen::Vector3d::UnitY()},
      PrescribedMotion{
          .direction = Eigen::Vector3d::UnitZ(), .amplitude_m = 0.02, .frequency_hz = 1.5});
  const World world = scene::build_world(sim_server::scene_of({driven}));
  const RigidBody& body = world.rigid_bodies[0];
  const double time_s = GENERATE(0.0, 0.1, 2.3), moment_s = 1e-5;

  const Eigen::Vector3d slope_m_s = (prescribed_state(body, time_s + moment_s).position_m -
                                     prescribed_state(body, time_s - moment_s).position_m) /
                                    (2.0 * moment_s);

  CHECK((slope_m_s - prescribed_state(body, time_s).velocity_m_s).norm() < 1e-9);
  CHECK(prescribed_state(body, 0.0).position_m == driven.position_m);
  CHECK(body.velocity_m_s == prescribed_state(body, 0.0).velocity_m_s);
}

TEST_CASE("Energy counts motion, spin, height and stretch of what is free", "[world]") {
  const Eigen::Vector3d gravity_m_s2(0, 0, -10);
  World world = scene::build_world(sim_server::scene_of(
      {sim_server::moving(sim_server::box({0, 0, 2}, {1, 2, 3}, 12.0, {1.0, 0.5}), {1, 0, 0},
                          {0, 0, 2}),
       sim_server::thread(2, {0, 0, 0}, {1, 0, 0}, 0.5, 8.0, {0})},
      {}, gravity_m_s2));
  world.nodes[1].position_m = {2, 0, 1};  // stretched by sqrt(5) - 1

  const double stretch_m = std::sqrt(5.0) - 1.0;
  CHECK(mechanical_energy_J(world) ==
        Approx(6.0 + 0.5 * 5.0 * 4.0 + 240.0 + 5.0 + 4.0 * stretch_m * stretch_m));
}

}  // namespace
}  // namespace stillgrid::bodies::world_test
