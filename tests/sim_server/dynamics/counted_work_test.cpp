#include "sim_server/dynamics/choice/counted_work.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "sim_server/scene/build_world.hpp"
#include "tests/sim_server/dynamics/joined.hpp"
#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::counted_work_test {
namespace {

/// A chain that swings down from the level.
scene::SceneDescription swinging_chain(double stiffness_N_per_m) {
  return sim_server::scene_of(
      {sim_server::thread(6, {0, 0, 0}, {0.5, 0, 0}, 0.01, stiffness_N_per_m, {0})}, {},
      {0.0, 0.0, -9.81});
}

MethodChoice choose(const scene::SceneDescription& scene, double step_s) {
  return choose_method(load_of(scene::build_world(scene)), step_s);
}

TEST_CASE("The spectrum decides the method: stiff springs are left to the implicit one",
          "[counted_work]") {
  const MethodChoice soft = choose(swinging_chain(50.0), 0.02);
  CHECK(scene::describe(soft.method) == "velocity_verlet");
  CHECK(soft.why.find("at most 16") != std::string::npos);
  const MethodChoice stiff = choose(swinging_chain(1e9), 0.02);
  CHECK(scene::describe(stiff.method) == "implicit_euler");
  CHECK(stiff.why.find("more than 16") != std::string::npos);
  // The same springs in a step so short that few substeps keep it stable.
  CHECK(scene::describe(choose(swinging_chain(1e9), 1e-5).method) == "velocity_verlet");
  // A long step has many ticks: each is judged.
  CHECK(choose(swinging_chain(50.0), 0.1).why.find("tick of 1 ms into") != std::string::npos);
  CHECK(scene::describe(choose(swinging_chain(50.0), 0.1).method) == "velocity_verlet");
}

TEST_CASE("A scene where nothing is free is left to the explicit method", "[counted_work]") {
  CHECK(scene::describe(choose(sim_server::scene_of({sim_server::floor_at(0.0)}), 0.1).method) ==
        "velocity_verlet");
}

TEST_CASE("A pendulum by the chosen method keeps below the height that it began at",
          "[counted_work]") {
  // A rod of 0.4 m on a pin, let go at 50 degrees; BDF2 once took it over the top.
  constexpr double kLength_m = 0.4, kAngle_rad = 50.0 * std::numbers::pi / 180.0;
  const Eigen::Vector3d pin_m(0, 0, 0);
  bodies::BodyDescription rod =
      sim_server::box({0, 0, 0}, {0.02, 0.02, kLength_m}, 0.1, {0.02, 0.01});
  rod.orientation = Eigen::AngleAxisd(kAngle_rad, Eigen::Vector3d::UnitY());
  rod.position_m = pin_m - rod.orientation * Eigen::Vector3d(0, 0, 0.5 * kLength_m);
  scene::SceneDescription scene = joined_scene({rod}, {joint(0, -1, {pin_m}, 2000.0, 0.0)}, 9.81);
  scene.period_s = 0.01;
  scene.method = choose(scene, scene.period_s).method;
  CAPTURE(scene::describe(scene.method));
  Simulation simulation(scene);
  const double start_J = bodies::mechanical_energy_J(simulation.world());
  const double swing_J = 0.1 * 9.81 * 0.5 * kLength_m * (1.0 - std::cos(kAngle_rad));
  double most_J = start_J;
  for (int i = 0; i < 1000; ++i) {
    REQUIRE(advance(simulation, scene.period_s, 1));
    most_J = std::max(most_J, bodies::mechanical_energy_J(simulation.world()));
  }
  CHECK(most_J - start_J < 0.05 * swing_J);
}

TEST_CASE("The predicted limit of stability is that of the oscillator", "[counted_work]") {
  // cases: a mass on one spring, w = sqrt(k / m) = 100 rad/s: 2 / w, and with zeta = 0.2 less.
  scene::SceneDescription scene =
      sim_server::scene_of({sim_server::thread(2, {0, 0, 0}, {0.1, 0, 0}, 0.1, 1000.0, {0})});
  const double free_s = stable_step_s(load_of(scene::build_world(scene)));
  sim_server::springs(scene.bodies[0]).spring_damping_N_s_per_m =
      2.0 * 0.2 * std::sqrt(1000.0 * 0.1);
  const double damped_s = stable_step_s(load_of(scene::build_world(scene)));

  CHECK(free_s == Approx(0.0200).epsilon(0.06));
  CHECK(damped_s == Approx(0.01640).epsilon(0.06));
}

TEST_CASE("Work grows with substeps, springs and contacts, and the default step keeps a quarter",
          "[counted_work]") {
  scene::SceneDescription light = swinging_chain(50.0);
  const SceneLoad load = load_of(scene::build_world(light));
  const scene::Method verlet{.integrator = scene::IntegratorKind::kVelocityVerlet};
  const double fixed = work_of(load, verlet, {.contacts = 3.0});
  CHECK(work_of(load, verlet, {.iterations = 2.0, .contacts = 3.0}) - fixed ==
        Approx(2.0 * (work_of(load, verlet, {.iterations = 1.0, .contacts = 3.0}) - fixed)));
  CHECK(work_of(load, verlet, {.iterations = 1.0, .contacts = 3.0}) >
        work_of(load, verlet, {.iterations = 1.0}) + 100.0);

  light.names_step = false;
  settle_step(light, scene::build_world(light));
  CHECK(light.period_s == 1e-3);
  scene::SceneDescription heavy = sim_server::scene_of(
      {sim_server::sheet({60, 60}, 0.01, 1e-4, 1e5)}, sim_server::material_of(100.0));
  heavy.names_step = false;
  settle_step(heavy, scene::build_world(heavy));
  CHECK(heavy.period_s == 0.01);
}

}  // namespace
}  // namespace stillgrid::dynamics::counted_work_test
