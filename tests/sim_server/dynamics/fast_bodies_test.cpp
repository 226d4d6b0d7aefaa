#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::fast_bodies_test {
namespace {

constexpr double kPeriod_s = 0.0333;
constexpr double kContactDistance_m = 0.015;  // 10 mm + 5 mm

bodies::BodyDescription target() {
  bodies::BodyDescription body = sim_server::sphere({0, 0, 0}, 0.01, 0.0);
  body.motion = bodies::Motion::kStatic;
  return body;
}

/// Whether a ball of 5 mm that flies along x is seen by its places at the steps' ends alone.
bool is_seen_at_ends(double start_m, double speed_m_s) {
  for (double x_m = start_m; x_m < kContactDistance_m; x_m += speed_m_s * kPeriod_s)
    if (std::abs(x_m) < kContactDistance_m) return true;
  return false;
}

/// Whether it is deflected on its way past the target, aside_m off its centre.
bool is_deflected(double start_m, double speed_m_s, double aside_m) {
  Simulation simulation(sim_server::scene_of(
      {target(), sim_server::moving(sim_server::sphere({start_m, aside_m, 0}, 0.005, 0.01),
                                    {speed_m_s, 0, 0})},
      sim_server::material_of(1e5)));
  const int steps = static_cast<int>((0.1 - start_m) / (speed_m_s * kPeriod_s)) + 1;
  int left = 0;
  for (int i = 0; i < steps; ++i) left += simulation.step(kPeriod_s, no_tool).crossings_left;
  CHECK(left == 0);
  const Eigen::Vector3d change_m_s =
      simulation.world().rigid_bodies[0].velocity_m_s - Eigen::Vector3d(speed_m_s, 0, 0);
  return change_m_s.norm() > 1e-5 * speed_m_s;
}

/// Methods that solve a step or divide it, and one that has all its substeps given.
scene::Method any_method() {
  return GENERATE(
      scene::Method{.integrator = scene::IntegratorKind::kImplicitEuler},
      scene::Method{.integrator = scene::IntegratorKind::kVelocityVerlet},
      scene::Method{.integrator = scene::IntegratorKind::kVelocityVerlet, .substeps = 50});
}

TEST_CASE("Steps' ends alone miss 1 - 2 A / (v P) of the balls that cross, the simulation none",
          "[fast_bodies]") {
  const double speed_m_s = GENERATE(0.5, 1.0, 2.0, 10.0, 100.0);
  const double stride_m = speed_m_s * kPeriod_s;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> phase(0.0, 1.0);
  constexpr int kBalls = 4000, kFlown = 40;
  int missed = 0, missed_by_us = 0;
  for (int i = 0; i < kBalls; ++i) {
    const double start_m = -kContactDistance_m - stride_m * (0.001 + phase(random));
    if (!is_seen_at_ends(start_m, speed_m_s)) ++missed;
    if (i < kFlown && !is_deflected(start_m, speed_m_s, 0.0)) ++missed_by_us;
  }

  CHECK(double(missed) / kBalls ==
        Approx(std::max(0.0, 1.0 - 2.0 * kContactDistance_m / stride_m)).margin(0.02));
  CHECK(missed_by_us == 0);
}

TEST_CASE("A ball that meets its target off centre is deflected, one that passes by is not",
          "[fast_bodies]") {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> aside(0.0, 0.02), speed(0.5, 50.0), start(-0.3, -0.05);
  for (int i = 0; i < 100; ++i) {
    const double aside_m = aside(random), start_m = start(random), speed_m_s = speed(random);
    INFO("aside " << aside_m << " m, from " << start_m << " m at " << speed_m_s << " m/s");
    if (aside_m > kContactDistance_m) CHECK_FALSE(is_deflected(start_m, speed_m_s, aside_m));
    if (aside_m < kContactDistance_m - 5e-5) CHECK(is_deflected(start_m, speed_m_s, aside_m));
  }
}

TEST_CASE("What falls faster and faster meets what it would fall through in a step",
          "[fast_bodies]") {
  // From rest 11 mm above a small ball: a step's fall is 98 mm, none of it in the velocity before.
  bodies::BodyDescription ledge = sim_server::sphere({0, 0, 0}, 0.002, 0.0);
  ledge.motion = bodies::Motion::kStatic;
  Simulation simulation(
      sim_server::scene_of({ledge, sim_server::sphere({0, 0, 0.015}, 0.002, 0.01)},
                           sim_server::material_of(1e4), {0, 0, -9.81}));

  CHECK(advance(simulation, 0.1, 1));

  CHECK(simulation.world().rigid_bodies[0].position_m.z() > -0.05);
}

TEST_CASE("A shot is stopped by a cloth that it would cross in a step", "[fast_bodies]") {
  bodies::BodyDescription cloth = sim_server::sheet({8, 8}, 0.02, 0.01, 5000.0);
  sim_server::shear_stiffness_N_per_m(cloth) = 1000.0;
  sim_server::packing(cloth) = {0.01, 0.0065};
  sim_server::springs(cloth).pinned_nodes = {0, 7, 56, 63};
  Simulation simulation(sim_server::scene_of(
      {cloth,
       sim_server::moving(sim_server::sphere({0.003, 0.002, 0.1}, 0.005, 0.005), {0, 0, -8.0})},
      sim_server::material_of(2e4)));
  for (int i = 0; i < 3; ++i) CHECK(simulation.step(kPeriod_s, no_tool).crossings_left == 0);

  CHECK(simulation.world().rigid_bodies[0].position_m.z() > -0.1);
  CHECK(simulation.world().rigid_bodies[0].velocity_m_s.z() > -4.0);
}

TEST_CASE("A tool that jumps over a ball in one step strikes it on its way", "[fast_bodies]") {
  scene::SceneDescription scene = sim_server::scene_of({sim_server::sphere({0, 0, 0}, 0.01, 0.1)},
                                                       sim_server::material_of(1000.0));
  scene.tool = {{Eigen::Vector3d::Zero(), 0.005}};
  std::mt19937 random(9);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d nearest_m =
        0.013 * Eigen::Vector3d(place(random), place(random), place(random)).normalized();
    const Eigen::Vector3d along =
        nearest_m.cross(Eigen::Vector3d(place(random), place(random), place(random))).normalized();
    const double jump_m = 0.05 + std::abs(place(random));
    Simulation simulation(scene);
    const auto sample_at = [&](double side) {
      return [&, side] { return ToolSample{.position_m = nearest_m + side * jump_m * along}; };
    };
    (void)simulation.step(0.01, sample_at(-1.0));
    REQUIRE(simulation.world().rigid_bodies[0].velocity_m_s.isZero(0.0));
    const StepReport report = simulation.step(0.01, sample_at(1.0));

    CHECK(report.crossings_left == 0);
    CHECK(simulation.world().rigid_bodies[0].velocity_m_s.norm() > 0.0);
  }
}

TEST_CASE("A tool that comes at rest into the scene has no path", "[fast_bodies]") {
  scene::SceneDescription scene = sim_server::scene_of({sim_server::sphere({0, 0, 0}, 0.01, 0.1)},
                                                       sim_server::material_of(1000.0));
  scene.tool = {{Eigen::Vector3d::Zero(), 0.005}};
  Simulation simulation(scene);
  const auto at = [](double x_m) {
    return [x_m] { return ToolSample{.position_m = {x_m, 0, 0}}; };
  };
  (void)simulation.step(0.01, at(-1.0));
  (void)simulation.step(0.01, no_tool);
  (void)simulation.step(0.01, at(1.0));

  CHECK(simulation.world().rigid_bodies[0].velocity_m_s.isZero(0.0));
}

TEST_CASE("A tool that comes moving is met where it came from, by every method", "[fast_bodies]") {
  // Seen from the ball it stays away; from where the ball moves on it ends where the ball began.
  const Eigen::Vector3d speed_m_s(1.0, 0.0, 0.0);
  scene::SceneDescription scene = sim_server::scene_of(
      {sim_server::moving(sim_server::sphere({0, 0, 0}, 0.01, 0.1), speed_m_s)},
      sim_server::material_of(1000.0));
  scene.tool = {{Eigen::Vector3d::Zero(), 0.005}};
  scene.method = any_method();
  Simulation simulation(scene);
  (void)simulation.step(kPeriod_s, [&] {
    return ToolSample{.time_ns = 1, .position_m = {0.0, 0.001, 0}, .velocity_m_s = speed_m_s};
  });

  CHECK(simulation.world().rigid_bodies[0].velocity_m_s == speed_m_s);
}

TEST_CASE("What is struck within a step does not pass its neighbour, whatever the integrator",
          "[fast_bodies]") {
  // The ball leaves the hammer's path at up to twice its speed, towards one that no step predicted.
  const double speed_m_s = GENERATE(5.0, 10.0, 20.0);
  const double lead = GENERATE(0.0, 0.03, 0.06, 0.09);  // of the step, before the hammer meets it
  const auto integrator =
      GENERATE(scene::IntegratorKind::kImplicitEuler, scene::IntegratorKind::kVelocityVerlet);
  bodies::BodyDescription hammer =
      sim_server::sphere({-0.0251 - lead * speed_m_s * kPeriod_s, 0, 0}, 0.02, 0.0);
  hammer.motion = bodies::Motion::kPrescribed;
  hammer.prescribed = {.velocity_m_s = speed_m_s * Eigen::Vector3d::UnitX()};
  scene::SceneDescription scene =
      sim_server::scene_of({hammer, sim_server::sphere({0, 0, 0}, 0.005, 0.001),
                            sim_server::sphere({0.02, 0, 0}, 0.005, 0.001)},
                           sim_server::material_of(1e5));
  scene.method.integrator = integrator;
  Simulation simulation(scene);
  (void)simulation.step(kPeriod_s, no_tool);

  const std::vector<bodies::RigidBody>& bodies = simulation.world().rigid_bodies;
  INFO(scene::name_of(integrator) << ", " << speed_m_s << " m/s, " << lead);
  CHECK(bodies[0].position_m.x() < bodies[1].position_m.x());
  CHECK(bodies[1].position_m.x() < bodies[2].position_m.x());
}

TEST_CASE("Every ball within a swing's reach is met, though it turns within a step",
          "[fast_bodies]") {
  const scene::Method method = any_method();
  const auto [amplitude_m, frequency_hz, balls] =
      GENERATE(table<double, double, int>({{0.1, 5.0, 20}, {0.05, 10.0, 17}}));
  std::mt19937 random(12);
  std::uniform_real_distribution<double> depth(0.0003, 0.012), period(0.028, 0.034);
  int missed = 0, left = 0;
  for (int i = 0; i < balls; ++i) {
    bodies::BodyDescription hammer = sim_server::sphere({0, 0, 0}, 0.009, 0.0);
    hammer.motion = bodies::Motion::kPrescribed;
    hammer.prescribed = {.direction = Eigen::Vector3d::UnitX(),
                         .amplitude_m = amplitude_m,
                         .frequency_hz = frequency_hz};
    const double period_s = period(random);
    scene::SceneDescription scene = sim_server::scene_of(
        {hammer, sim_server::sphere({amplitude_m + 0.015 - depth(random), 0, 0}, 0.006, 0.02)},
        sim_server::material_of(1000.0, 1.0));
    scene.method = method;
    Simulation simulation(scene);
    while (simulation.world().time_s < 0.75 / frequency_hz)
      left += simulation.step(period_s, no_tool).crossings_left;
    if (simulation.world().rigid_bodies[1].velocity_m_s.isZero(0.0)) ++missed;
  }
  INFO(scene::name_of(method.integrator) << ", " << frequency_hz << " Hz");
  CHECK(missed == 0);
  CHECK(left == 0);
}

TEST_CASE("A sleeping ball that a swing meets between the ends of a step wakes", "[fast_bodies]") {
  bodies::BodyDescription hammer = sim_server::sphere({0, 0, 0}, 0.009, 0.0);
  hammer.motion = bodies::Motion::kPrescribed;
  hammer.prescribed = {
      .direction = Eigen::Vector3d::UnitX(), .amplitude_m = 0.05, .frequency_hz = 0.25};
  scene::SceneDescription scene = sim_server::scene_of(
      {hammer, sim_server::sphere({0.055, 0, 0}, 0.006, 0.02)}, sim_server::material_of(1000.0));
  scene.sleeping = true;
  scene.method = any_method();
  Simulation simulation(scene);
  for (int i = 0; i < 14; ++i) (void)simulation.step(0.04, no_tool);
  REQUIRE(simulation.world().bodies[1].is_sleeping);
  (void)simulation.step(0.9, no_tool);  // the turn is at 1 s

  CHECK_FALSE(simulation.world().rigid_bodies[1].velocity_m_s.isZero(0.0));
}

TEST_CASE("What a spring hurls from rest meets what is on its way", "[fast_bodies]") {
  // Half a swing of 30 ms to the far side, or what a method makes of it; no velocity tells of it.
  const scene::Method method = any_method();
  const double ball_m = GENERATE(0.105, 0.1, 0.093, 0.087);
  scene::SceneDescription scene =
      sim_server::scene_of({sim_server::thread(2, {0, 0, 0}, {0.1, 0, 0}, 0.01, 110.0, {0}),
                            sim_server::sphere({ball_m, 0.009, 0}, 0.004, 0.001)},
                           sim_server::material_of(500.0));
  scene.method = method;
  bodies::World world = scene::build_world(scene);
  world.nodes[1].position_m.x() = 0.13;
  Simulation simulation(scene, world);
  const StepReport report = simulation.step(kPeriod_s, no_tool);

  INFO(scene::name_of(method.integrator) << ", " << ball_m << " m");
  CHECK(report.crossings_left == 0);
  const double end_m = simulation.world().nodes[1].position_m.x();
  if (end_m < ball_m) CHECK_FALSE(simulation.world().rigid_bodies[0].velocity_m_s.isZero(0.0));
}

TEST_CASE("What rests or slides in touch takes one step, though gravity would part it",
          "[fast_bodies]") {
  Simulation simulation(sim_server::scene_of(
      {target(), sim_server::moving(sim_server::sphere({0, 0, 0.0149}, 0.005, 0.01), {0, 0, 0}),
       sim_server::moving(sim_server::box({0, 0, -0.03}, {0.03, 0.03, 0.02}, 0.02, {0.01, 0.005}),
                          {0.2, 0, 0}),
       sim_server::floor_at(-0.04)},
      sim_server::material_of(1000.0), {0, 0, -9.81}));

  for (int i = 0; i < 10; ++i) CHECK(simulation.step(kPeriod_s, no_tool).substeps == 1);
}

TEST_CASE("A step shortened at crossings repeats to the bit", "[fast_bodies]") {
  std::vector<bodies::BodyDescription> bodies;
  std::mt19937 random(10);
  std::uniform_real_distribution<double> place(-0.05, 0.05), speed(-10.0, 10.0);
  for (int i = 0; i < 40; ++i)
    bodies.push_back(sim_server::moving(
        sim_server::sphere({place(random), place(random), place(random)}, 0.004, 0.01),
        {speed(random), speed(random), speed(random)}));
  const scene::SceneDescription scene =
      sim_server::scene_of(bodies, sim_server::material_of(1000.0, 0.5, 0.3));
  Simulation one(scene), other(scene);
  int substeps = 0;
  for (int i = 0; i < 4; ++i) {
    substeps += one.step(kPeriod_s, no_tool).substeps;
    (void)other.step(kPeriod_s, no_tool);
  }

  CHECK(substeps > 8);
  for (std::size_t i = 0; i < bodies.size(); ++i)
    CHECK(one.world().rigid_bodies[i].position_m == other.world().rigid_bodies[i].position_m);
}

}  // namespace
}  // namespace stillgrid::dynamics::fast_bodies_test
