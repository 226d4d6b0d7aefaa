#include <algorithm>
#include <catch2/catch.hpp>
#include <numbers>

#include "sim_server/bodies/sphere_motion.hpp"
#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::self_contact_test {
namespace {

constexpr double kStep_s = 0.01;

/// Pairs of spheres of the world that overlap, neighbours or not.
int overlaps(const bodies::World& world) {
  int count = 0;
  for (std::size_t i = 0; i < world.spheres.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      count += (bodies::sphere_motion(world, world.spheres[i]).position_m -
                bodies::sphere_motion(world, world.spheres[j]).position_m)
                   .norm() < world.spheres[i].radius_m + world.spheres[j].radius_m;
  return count;
}

double fastest_m_s(const bodies::World& world) {
  double speed_m_s = 0.0;
  for (const bodies::Node& node : world.nodes)
    speed_m_s = std::max(speed_m_s, node.velocity_m_s.norm());
  return speed_m_s;
}

std::vector<spheres::Ball> bar(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m) {
  std::vector<spheres::Ball> balls;
  for (int i = 0; i <= 6; ++i) balls.push_back({from_m + i / 6.0 * (to_m - from_m), 0.01});
  return balls;
}

/// Two arms, 60 mm long, 15 mm between them, joined at one end.
bodies::BodyDescription c_shape() {
  std::vector<spheres::Ball> balls = bar({0, 0, 0}, {0.06, 0, 0});
  for (const auto& more : {bar({0, 0, 0.035}, {0.06, 0, 0.035}), bar({0, 0, 0}, {0, 0, 0.035})})
    balls.insert(balls.end(), more.begin(), more.end());
  bodies::BodyDescription body = sim_server::soft_mesh(balls, 0.01, 1e-4, 10.0);
  sim_server::springs(body).spring_damping_N_s_per_m = 0.005;
  return body;
}

TEST_CASE("A body at rest does not touch itself, though its spheres overlap", "[self_contact]") {
  bodies::BodyDescription cloth = sim_server::sheet({8, 8}, 0.02, 0.002, 500.0);
  sim_server::packing(cloth) = {0.01, 0.0065};
  bodies::BodyDescription block =
      sim_server::soft_block({4, 4, 4}, 0.01, 1e-3, 100.0, {0.006, 0.005});
  bodies::BodyDescription string = sim_server::thread(12, {0, 0, 0}, {0.1, 0, 0}, 0.01, 100.0);
  sim_server::packing(string) = {0.005, 0.004};
  // By number: what GENERATE_COPY keeps of a temporary is gone when it is read.
  const std::vector<bodies::BodyDescription> bodies = {cloth, block, string, c_shape()};
  const std::size_t body = GENERATE(range<std::size_t>(0, 4));
  Simulation simulation(
      sim_server::scene_of({bodies[body]}, sim_server::material_of(1000.0, 1.0, 0.3)));
  REQUIRE(overlaps(simulation.world()) > 10);  // each would push

  for (int i = 0; i < 20; ++i) CHECK(simulation.step(kStep_s, no_tool).contacts == 0);
  CHECK(fastest_m_s(simulation.world()) < 1e-12);
}

TEST_CASE("A folded cloth rests on itself", "[self_contact]") {
  constexpr int kColumns = 13, kRows = 7;
  constexpr double kRadius_m = 0.004;
  bodies::BodyDescription cloth = sim_server::sheet({kColumns, kRows}, 0.01, 1e-3, 50.0);
  sim_server::shear_stiffness_N_per_m(cloth) = 20.0;
  sim_server::springs(cloth).spring_damping_N_s_per_m = 0.05;
  sim_server::packing(cloth) = {0.005, kRadius_m};
  for (int i = 0; i < kColumns * kRows; ++i)
    if (i % kColumns <= kColumns / 2) sim_server::springs(cloth).pinned_nodes.push_back(i);
  Simulation simulation(
      sim_server::scene_of({cloth}, sim_server::material_of(500.0, 0.5, 0.3), {0, 0, -9.81}));
  for (bodies::Node& node : simulation.world().nodes)
    if (node.position_m.x() > 1e-9) {
      node.position_m.x() *= -1.0;
      node.position_m.z() = 3.0 * kRadius_m;
    }
  CHECK(advance(simulation, kStep_s, 150));

  // Away from the fold the upper half lies on the pinned lower one, hardly pressed in.
  for (int i = 0; i < kColumns * kRows; ++i) {
    const bodies::Node& node = simulation.world().nodes[static_cast<std::size_t>(i)];
    if (i % kColumns < kColumns / 2 + 4) continue;
    CHECK(node.position_m.z() > 1.2 * kRadius_m);  // spheres settle between spheres
    CHECK(node.position_m.z() < 2.2 * kRadius_m);
  }
  CHECK(simulation.step(kStep_s, no_tool).contacts > 20);
  CHECK(fastest_m_s(simulation.world()) < 0.01);
}

TEST_CASE("A looped thread lies across itself", "[self_contact]") {
  constexpr double kRadius_m = 0.004, kSpacing_m = 0.006;
  constexpr int kNodes = 40;
  bodies::BodyDescription string =
      sim_server::thread(kNodes, {0, 0, 0}, {kSpacing_m * (kNodes - 1), 0, 0}, 1e-3, 200.0);
  sim_server::springs(string).bend_stiffness_N_per_m = 2.0;
  sim_server::springs(string).spring_damping_N_s_per_m = 0.05;
  sim_server::packing(string) = {kSpacing_m, kRadius_m};
  for (int i = 0; i < 14; ++i) sim_server::springs(string).pinned_nodes.push_back(i);
  Simulation simulation(sim_server::scene_of({string, sim_server::floor_at(-kRadius_m)},
                                             sim_server::material_of(500.0, 0.5, 0.3),
                                             {0, 0, -9.81}));
  // Straight along x, round three quarters of a circle that climbs, back across the beginning.
  constexpr double kTurn_m = 0.02;
  for (int i = 14; i < kNodes; ++i) {
    const double along_m = kSpacing_m * (i - 13), angle = std::min(along_m / kTurn_m, 4.71);
    const double rest_m = along_m - angle * kTurn_m;
    simulation.world().nodes[static_cast<std::size_t>(i)].position_m = {
        kSpacing_m * 13 + kTurn_m * std::sin(angle), kTurn_m * (1.0 - std::cos(angle)) - rest_m,
        std::min(0.012, 0.003 * (i - 13))};
  }
  CHECK(advance(simulation, kStep_s, 150));

  const bodies::World& world = simulation.world();
  double highest_m = 0.0;
  for (std::size_t i = 20; i < kNodes; ++i)
    highest_m = std::max(highest_m, world.nodes[i].position_m.z());
  CHECK(highest_m > 1.2 * kRadius_m);  // where it crosses
  for (std::size_t i = 0; i < 14; ++i)
    for (std::size_t j = 20; j < kNodes; ++j)
      CHECK((world.nodes[i].position_m - world.nodes[j].position_m).norm() > 1.4 * kRadius_m);
  CHECK(fastest_m_s(world) < 0.05);
}

TEST_CASE("The arms of a soft C that are thrown together stop each other", "[self_contact]") {
  Simulation simulation(sim_server::scene_of({c_shape()}, sim_server::material_of(2000.0, 1.0)));
  for (bodies::Node& node : simulation.world().nodes)
    if (node.position_m.x() > 0.02)
      node.velocity_m_s.z() = node.position_m.z() > 0.0175 ? -2.0 : 2.0;
  const double start_J = bodies::mechanical_energy_J(simulation.world());

  int most_contacts = 0;
  double narrowest_m = 1.0;
  for (int i = 0; i < 120; ++i) {
    most_contacts = std::max(most_contacts, simulation.step(0.001, no_tool).contacts);
    const bodies::World& world = simulation.world();
    // The tips: the last ball of either arm.
    const double apart_m = bodies::sphere_motion(world, world.spheres[13]).position_m.z() -
                           bodies::sphere_motion(world, world.spheres[6]).position_m.z();
    narrowest_m = std::min(narrowest_m, apart_m);
    CHECK(bodies::mechanical_energy_J(world) <= start_J + 1e-9);
  }

  CHECK(most_contacts > 0);
  CHECK(narrowest_m > 0.01);   // of 20 mm at touch
  CHECK(narrowest_m < 0.021);  // they did meet
}

/// Greatest share of the energy at the start that the arms of a soft C come to have more, thrown
/// together at a speed.
double gain_of_arms(double speed_m_s, double step_s) {
  scene::SceneDescription scene =
      sim_server::scene_of({c_shape()}, sim_server::material_of(2000.0, 1.0));
  Simulation simulation(scene);
  for (bodies::Node& node : simulation.world().nodes)
    if (node.position_m.x() > 0.02)
      node.velocity_m_s.z() = node.position_m.z() > 0.0175 ? -speed_m_s : speed_m_s;
  const double start_J = bodies::mechanical_energy_J(simulation.world());
  double gain = 0.0;
  for (int i = 0; i < 120; ++i) {
    CHECK(advance(simulation, step_s, 1));
    gain = std::max(gain, bodies::mechanical_energy_J(simulation.world()) / start_J - 1.0);
  }
  return gain;
}

TEST_CASE("Steps that go downhill gain no energy where the arms of a soft C fold",
          "[self_contact]") {
  const double speed_m_s = GENERATE(0.5, 2.0, 5.0), step_s = GENERATE(0.001, 0.003, 0.01);

  INFO(speed_m_s << " m/s, steps of " << step_s << " s");
  CHECK(gain_of_arms(speed_m_s, step_s) <= 1e-9);
}

}  // namespace
}  // namespace stillgrid::dynamics::self_contact_test
