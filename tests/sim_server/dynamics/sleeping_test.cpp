#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/dynamics/ticks/described_world.hpp"
#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::sleeping_test {
namespace {

constexpr double kStep_s = 0.01, kEdge_m = 0.03;

scene::SceneDescription sleeping_scene(std::vector<bodies::BodyDescription> bodies,
                                       bool sleeping = true) {
  scene::SceneDescription scene = sim_server::scene_of(
      std::move(bodies), sim_server::material_of(1250.0, 2.0, 0.5), {0, 0, -9.81});
  scene.tool = {{Eigen::Vector3d::Zero(), 0.005}};
  scene.sleeping = sleeping;
  return scene;
}

bodies::BodyDescription block_at(const Eigen::Vector3d& centre_m) {
  return sim_server::box(centre_m, Eigen::Vector3d::Constant(kEdge_m), 0.1, {0.02, 0.005});
}

/// A floor at height 0, and blocks on it, one upon the other.
std::vector<bodies::BodyDescription> stack(int blocks) {
  std::vector<bodies::BodyDescription> bodies{sim_server::floor_at(0.0)};
  for (int i = 0; i < blocks; ++i) bodies.push_back(block_at({0, 0, (i + 0.48) * kEdge_m}));
  return bodies;
}

int count_sleeping(const Simulation& simulation) {
  const auto& bodies = simulation.world().bodies;
  return static_cast<int>(
      std::count_if(bodies.begin(), bodies.end(),
                    [](const bodies::BodyRange& body) { return body.is_sleeping; }));
}

std::vector<Eigen::Vector3d> places(const Simulation& simulation) {
  std::vector<Eigen::Vector3d> result;
  for (const bodies::SphereBinding& sphere : simulation.world().spheres)
    result.push_back(bodies::sphere_motion(simulation.world(), sphere).position_m);
  return result;
}

double farthest_m(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b) {
  double distance_m = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    distance_m = std::max(distance_m, (a[i] - b[i]).norm());
  return distance_m;
}

/// Steps until so many bodies sleep, twenty seconds at most.
void lull(Simulation& simulation, int bodies) {
  for (int i = 0; i < 2000 && count_sleeping(simulation) < bodies; ++i)
    (void)simulation.step(kStep_s, no_tool);
  REQUIRE(count_sleeping(simulation) == bodies);
}

StepReport step_with_tool_at(Simulation& simulation, const Eigen::Vector3d& position_m) {
  return simulation.step(kStep_s, [&] { return ToolSample{.position_m = position_m}; });
}

TEST_CASE("A stack at rest sleeps, and moves by no bit while it does", "[sleeping]") {
  Simulation simulation(sleeping_scene(stack(5)));
  lull(simulation, 5);
  const auto before = places(simulation);

  for (int i = 0; i < 100; ++i) {
    const StepReport report = simulation.step(kStep_s, no_tool);
    REQUIRE(report.solve.converged);
    CHECK(report.contacts == 0);
    CHECK(report.sleeping_spheres == static_cast<int>(before.size()));
  }

  CHECK(farthest_m(places(simulation), before) == 0.0);
  for (const proto::SphereRecord& record : simulation.snapshot().records()) {
    CHECK(record.newest.velocity_m_s == std::array{0.0F, 0.0F, 0.0F});
    CHECK(record.newest.position_m == record.before.position_m);
  }
}

/// Bodies of so many sleeping after so long.
int sleeping_after(scene::SceneDescription scene, scene::IntegratorKind integrator,
                   double duration_s) {
  scene.method.integrator = integrator;
  Simulation simulation(scene);
  for (int i = 0; i < std::lround(duration_s / kStep_s); ++i)
    (void)simulation.step(kStep_s, no_tool);
  return count_sleeping(simulation);
}

TEST_CASE("A stack sleeps with every integrator that scenes may name", "[sleeping]") {
  const scene::IntegratorKind integrator = GENERATE(from_range(scene::kIntegrators));
  CAPTURE(scene::name_of(integrator));
  CHECK(sleeping_after(sleeping_scene(stack(1)), integrator, 10.0) == 1);
  CHECK(sleeping_after(sleeping_scene(stack(3)), integrator, 20.0) == 3);
}

TEST_CASE("What goes to sleep was slower than the threshold for half a second", "[sleeping]") {
  Simulation simulation(sleeping_scene(stack(3)));
  const auto& world = simulation.world();
  // 3 % of 5 mm a second, below a fifth of 1 mm/s.
  CHECK(rest_speed_m_s(world, world.bodies[1]) == Approx(0.15e-3));
  std::vector<double> speeds_m_s;
  while (count_sleeping(simulation) == 0 && speeds_m_s.size() < 2000) {
    (void)simulation.step(kStep_s, no_tool);
    const bodies::RigidBody& top = simulation.world().rigid_bodies[2];
    speeds_m_s.push_back(top.velocity_m_s.norm() +
                         top.bounding_radius_m * top.angular_velocity_rad_s.norm());
  }

  REQUIRE(count_sleeping(simulation) == 3);
  REQUIRE(speeds_m_s.size() > 50);
  CHECK(*std::max_element(speeds_m_s.end() - 50, speeds_m_s.end()) <
        rest_speed_m_s(world, world.bodies[3]));
}

TEST_CASE("A pile wakes as one when something falls on it, and sleeps again", "[sleeping]") {
  auto bodies = stack(4);
  bodies.push_back(sim_server::moving(sim_server::sphere({0, 0, 0.5}, 0.0125, 0.02),
                                      {0, 0, 12.0}));  // back after 2.5 s
  Simulation simulation(sleeping_scene(bodies));
  lull(simulation, 4);
  REQUIRE(simulation.world().rigid_bodies[4].position_m.z() > 0.3);  // still in the air
  bool was_struck = false;
  for (int i = 0; i < 300 && !was_struck; ++i) {
    const int is_sleeping = count_sleeping(simulation);
    const double falling_m_s = simulation.world().rigid_bodies[4].velocity_m_s.z();
    (void)simulation.step(kStep_s, no_tool);
    // Awake all or none, before the ball feels anything.
    CHECK((count_sleeping(simulation) == 0 || count_sleeping(simulation) == 4));
    const bool is_struck = simulation.world().rigid_bodies[4].velocity_m_s.z() > falling_m_s;
    CHECK((!is_struck || count_sleeping(simulation) == 0));
    was_struck = is_struck && is_sleeping == 4;
  }
  REQUIRE(was_struck);
  CHECK(simulation.world().rigid_bodies[3].velocity_m_s.z() < -0.01);  // the uppermost gave way

  lull(simulation, 5);
}

TEST_CASE("A blow moves a sleeper as it moves one that never slept", "[sleeping]") {
  // A ball slides along the floor, slowed by nothing, against a block.
  const auto struck = [](bool sleeping) {
    auto bodies = stack(1);
    bodies.push_back(sim_server::sphere({0.2, 0.0, 0.012}, 0.0125, 0.05));
    bodies.back().motion = bodies::Motion::kPrescribed;
    bodies.back().prescribed = {.velocity_m_s =
                                    -0.05 * Eigen::Vector3d::UnitX()};  // there after 3.4 s
    Simulation simulation(sleeping_scene(bodies, sleeping));
    std::vector<double> speeds_m_s;
    bool was_sleeping = false;
    for (int i = 0; i < 400; ++i) {
      (void)simulation.step(kStep_s, no_tool);
      was_sleeping = was_sleeping || count_sleeping(simulation) > 0;
      speeds_m_s.push_back(simulation.world().rigid_bodies[0].velocity_m_s.x());
    }
    CHECK(was_sleeping == sleeping);
    CHECK(count_sleeping(simulation) == 0);
    return speeds_m_s;
  };

  const auto woken = struck(true), waking = struck(false);

  CHECK(waking.back() == Approx(-0.05).margin(0.01));  // it is pushed along
  for (std::size_t i = 0; i < woken.size(); ++i) CHECK(std::abs(woken[i] - waking[i]) < 2e-4);
}

TEST_CASE("The tool wakes what it touches in the very step, and keeps it awake", "[sleeping]") {
  Simulation simulation(sleeping_scene(stack(2)));
  lull(simulation, 2);
  const double top_m = simulation.world().rigid_bodies[1].position_m.z() + 0.5 * kEdge_m;
  // Above one of the spheres of the upper face, which are 10 mm off the middle: first 5 mm clear.
  const auto above = [&](double clear_m) {
    return Eigen::Vector3d(0.01, 0.01, top_m + 0.005 + clear_m);
  };
  (void)step_with_tool_at(simulation, above(0.005));
  REQUIRE(count_sleeping(simulation) == 2);

  const StepReport touch = step_with_tool_at(simulation, above(-0.001));

  CHECK(touch.contacts > 0);
  CHECK(count_sleeping(simulation) == 0);
  CHECK(simulation.world().rigid_bodies[1].velocity_m_s.z() < 0.0);
  for (int i = 0; i < 300; ++i) (void)step_with_tool_at(simulation, above(-0.001));
  CHECK(count_sleeping(simulation) == 0);
  lull(simulation, 2);  // without it they sleep again
}

TEST_CASE("Nothing pops as it goes to sleep or wakes", "[sleeping]") {
  bodies::BodyDescription tissue = sim_server::sheet({6, 6}, 0.02, 0.002, 200.0);
  tissue.position_m.z() = 0.05;
  sim_server::shear_stiffness_N_per_m(tissue) = 100.0;
  sim_server::springs(tissue).spring_damping_N_s_per_m = 0.2;
  sim_server::springs(tissue).pinned_nodes = {0, 5, 30, 35};
  sim_server::packing(tissue) = {0.02, 0.0095};
  Simulation simulation(sleeping_scene({tissue, block_at({0, 0, 0.08})}));
  const double bound_m_s = rest_speed_m_s(simulation.world(), simulation.world().bodies[0]);
  auto before = places(simulation);
  for (int i = 0; i < 4000 && count_sleeping(simulation) < 2; ++i) {
    before = places(simulation);
    (void)simulation.step(kStep_s, no_tool);
  }
  REQUIRE(count_sleeping(simulation) == 2);
  CHECK(farthest_m(places(simulation), before) < kStep_s * bound_m_s);

  // The tool only just touches the block: what moves after that is what sleep had held.
  const auto still = places(simulation);
  Eigen::Vector3d highest_m = still[0];
  for (const Eigen::Vector3d& place_m : still)
    if (place_m.z() > highest_m.z()) highest_m = place_m;
  const Eigen::Vector3d touching_m = highest_m + Eigen::Vector3d(0, 0, 0.01 - 1e-9);
  double fastest_m_s = 0.0;
  for (int i = 0; i < 50; ++i) {
    before = places(simulation);
    (void)step_with_tool_at(simulation, touching_m);
    fastest_m_s = std::max(fastest_m_s, farthest_m(places(simulation), before) / kStep_s);
    if (i == 0) CHECK(count_sleeping(simulation) == 0);
  }
  CHECK(fastest_m_s < 2.0 * bound_m_s);
}

TEST_CASE("A pendulum does not go to sleep at its turning point", "[sleeping]") {
  // A rod of 1 m, that swings at 3.1 rad/s; slow steps look at few points of its way.
  const double angle_rad = GENERATE(0.01, 0.1, 1.0), step_s = GENERATE(0.01, 0.1);
  const Eigen::Vector3d end_m(std::sin(angle_rad), 0, -std::cos(angle_rad));
  Simulation simulation(sleeping_scene({sim_server::thread(2, {0, 0, 0}, end_m, 0.1, 1e5, {0})}));

  for (double time_s = 0.0; time_s < 4.0; time_s += step_s) {
    (void)simulation.step(step_s, no_tool);
    CHECK(count_sleeping(simulation) == 0);
  }
}

TEST_CASE("What slides down a slope stays awake, what the slope holds goes to sleep",
          "[sleeping]") {
  // tan 16.7 deg = 0.3
  const bool is_held = GENERATE(false, true);
  const double tilt_rad = (is_held ? 16.0 : 17.3) * std::numbers::pi / 180.0;
  scene::SceneDescription scene =
      sim_server::scene_of({sim_server::box({0, 0, 0.01}, {0.06, 0.06, 0.02}, 0.1, {0.05, 0.005}),
                            sim_server::floor_at(0.0)},
                           sim_server::material_of(500.0, 2.0, 0.3, 1e-3),
                           9.81 * Eigen::Vector3d(std::sin(tilt_rad), 0, -std::cos(tilt_rad)));
  scene.sleeping = true;
  Simulation simulation(scene);

  for (int i = 0; i < 300; ++i) {
    (void)simulation.step(kStep_s, no_tool);
    if (!is_held) CHECK(count_sleeping(simulation) == 0);
  }

  CHECK(count_sleeping(simulation) == (is_held ? 1 : 0));
}

TEST_CASE("A block that slept on a slope wakes held as it was", "[sleeping]") {
  // Let go, it would swing 14 um down the slope: its weight along it over the contacts' stiffness.
  const double tilt_rad = 10.0 * std::numbers::pi / 180.0;
  scene::SceneDescription scene =
      sim_server::scene_of({sim_server::box({0, 0, 0.01}, {0.06, 0.06, 0.02}, 0.1, {0.05, 0.005}),
                            sim_server::floor_at(0.0)},
                           sim_server::material_of(500.0, 2.0, 0.3),
                           9.81 * Eigen::Vector3d(std::sin(tilt_rad), 0, -std::cos(tilt_rad)));
  scene.sleeping = true;
  scene.tool = {{Eigen::Vector3d::Zero(), 0.005}};
  scene.method.integrator = scene::IntegratorKind::kVelocityVerlet;
  Simulation simulation(scene);
  lull(simulation, 1);
  simulation.account_energy();
  const double held_J = simulation.energy_account()->start.contacts_J;
  for (int i = 0; i < 10; ++i) (void)simulation.step(kStep_s, no_tool);
  CHECK(simulation.energy_account()->end.contacts_J == held_J);
  const auto before = places(simulation);

  // A tool that hardly touches.
  const double apart_m = simulation.world().spheres.back().radius_m + scene.tool[0].radius_m;
  (void)step_with_tool_at(simulation, before.back() + Eigen::Vector3d(0, 0, apart_m - 1e-9));
  REQUIRE(count_sleeping(simulation) == 0);
  for (int i = 0; i < 30; ++i) {
    (void)simulation.step(kStep_s, no_tool);
    CHECK(farthest_m(places(simulation), before) < 1e-7);
  }
}

TEST_CASE("A block whose support is taken away falls", "[sleeping]") {
  SECTION("by the tool, that pushes the lower block from below the upper one") {
    scene::SceneDescription scene = sleeping_scene(stack(2));
    scene.tool[0].radius_m = 0.01;
    Simulation simulation(scene);
    lull(simulation, 2);
    // It comes from the side, at 0.3 m/s, straight against one of the lower block's spheres.
    for (int i = 0; i < 60; ++i)
      (void)step_with_tool_at(simulation, {-0.05 + 0.003 * i, 0.01, 0.006});

    CHECK(simulation.world().rigid_bodies[0].position_m.x() > 0.01);
    lull(simulation, 2);
    CHECK(simulation.world().rigid_bodies[1].position_m.z() < 0.8 * kEdge_m);  // on the floor
  }
  SECTION("by a shelf that sinks through the floor: on that it never sleeps") {
    bodies::BodyDescription shelf =
        sim_server::box({0, 0, 0.095}, {0.05, 0.05, 0.01}, 0.0, {0.01, 0.005});
    shelf.motion = bodies::Motion::kPrescribed;
    shelf.prescribed = {.velocity_m_s = -0.05 * Eigen::Vector3d::UnitZ()};
    Simulation simulation(
        sleeping_scene({sim_server::floor_at(0.0), shelf, block_at({0, 0, 0.115})}));
    for (int i = 0; i < 150; ++i) {
      (void)simulation.step(kStep_s, no_tool);
      CHECK(count_sleeping(simulation) == 0);
    }
    lull(simulation, 1);
    CHECK(simulation.world().rigid_bodies[1].position_m.z() == Approx(0.5 * kEdge_m).margin(1e-3));
  }
}

TEST_CASE("On a shelf that is prescribed to stay a block sleeps as on the floor", "[sleeping]") {
  bodies::BodyDescription shelf =
      sim_server::box({0, 0, 0.095}, {0.05, 0.05, 0.01}, 0.0, {0.01, 0.005});
  shelf.motion = bodies::Motion::kPrescribed;
  Simulation simulation(sleeping_scene({shelf, block_at({0, 0, 0.115})}));

  lull(simulation, 1);

  for (int i = 0; i < 50; ++i) {
    (void)simulation.step(kStep_s, no_tool);
    CHECK(count_sleeping(simulation) == 1);
  }
}

TEST_CASE("Where all sleep steps only take time on, and the tool wakes as where they do not",
          "[sleeping]") {
  std::vector<bodies::BodyDescription> bodies = stack(2);
  Simulation passes(sleeping_scene(bodies));
  bodies::BodyDescription far = block_at({5, 5, 5});
  far.motion = bodies::Motion::kPrescribed;
  far.prescribed.velocity_m_s = {0.1, 0.0, 0.0};
  bodies.push_back(far);
  Simulation works(sleeping_scene(bodies));
  for (Simulation* simulation : {&passes, &works}) lull(*simulation, 2);
  const Eigen::Vector3d above_m(0.01, 0.01, 2.0 * kEdge_m + 0.0137);

  int passed = 0;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d tool_m = above_m - Eigen::Vector3d(0, 0, 3e-4 * std::max(0, i - 20));
    const StepReport report = step_with_tool_at(passes, tool_m);
    passed += report.solve.iterations == 0 ? 1 : 0;
    CHECK(report.sleeping_spheres == step_with_tool_at(works, tool_m).sleeping_spheres);
    CHECK(passes.world().time_s == Approx(works.world().time_s));
    for (std::size_t block : {0U, 1U})
      CHECK((passes.world().rigid_bodies[block].position_m -
             works.world().rigid_bodies[block].position_m)
                .norm() < 1e-12);
  }
  CHECK(passed > 10);
  CHECK(count_sleeping(passes) == 0);
}

TEST_CASE("Sleep repeats to the bit", "[sleeping]") {
  auto bodies = stack(3);
  bodies.push_back(
      sim_server::moving(sim_server::sphere({0.004, 0, 0.5}, 0.0125, 0.02), {0, 0, 5.0}));
  Simulation one(sleeping_scene(bodies)), other(sleeping_scene(bodies));
  int most_sleeping = 0;
  for (int i = 0; i < 400; ++i) {
    (void)one.step(kStep_s, no_tool);
    (void)other.step(kStep_s, no_tool);
    most_sleeping = std::max(most_sleeping, count_sleeping(one));
    REQUIRE(farthest_m(places(one), places(other)) == 0.0);
  }
  CHECK(most_sleeping > 0);
}

}  // namespace
}  // namespace stillgrid::dynamics::sleeping_test
