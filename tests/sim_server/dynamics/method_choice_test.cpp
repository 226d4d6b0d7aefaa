#include "sim_server/dynamics/choice/method_choice.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>

#include "sim_server/dynamics/choice/predicted_cost.hpp"
#include "tests/sim_server/dynamics/joined.hpp"
#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::method_choice_test {
namespace {

MethodChoice choose(const scene::SceneDescription& scene) {
  return choose_method(scene, [](const std::string&) {});
}

/// A chain that swings down from the level.
scene::SceneDescription swinging_chain(double stiffness_N_per_m = 50.0) {
  scene::SceneDescription scene = sim_server::scene_of(
      {sim_server::thread(6, {0, 0, 0}, {0.5, 0, 0}, 0.01, stiffness_N_per_m, {0})}, {},
      {0.0, 0.0, -9.81});
  scene.period_s = 0.02;
  return scene;
}

const MethodTrial& trial_of(const MethodChoice& choice, const std::string& name) {
  const auto found =
      std::find_if(choice.trials.begin(), choice.trials.end(),
                   [&](const MethodTrial& trial) { return scene::describe(trial.method) == name; });
  REQUIRE(found != choice.trials.end());
  return *found;
}

TEST_CASE("Of the methods that keep the error target the cheapest is chosen", "[method_choice]") {
  scene::SceneDescription scene = swinging_chain();
  scene.error_target_m = 1.0;

  const MethodChoice choice = choose(scene);

  CHECK(choice.meets_target);
  const MethodTrial chosen = trial_of(choice, scene::describe(choice.method));
  for (const MethodTrial& trial : choice.trials) {
    CAPTURE(scene::describe(trial.method), trial.refusal);
    CHECK((trial.method == choice.method) == trial.refusal.empty());
    if (trial.error_m) CHECK(*chosen.step_ms <= *trial.step_ms);
  }
}

TEST_CASE("A method that misses the error target is refused however cheap it is",
          "[method_choice]") {
  scene::SceneDescription scene = swinging_chain(1e5);  // many substeps for one implicit step
  scene.error_target_m = 1e-3;
  const MethodChoice strict = choose(scene);
  scene.error_target_m = 1.0;
  const MethodChoice loose = choose(scene);

  CHECK(scene::describe(strict.method) == "velocity_verlet");
  CHECK(trial_of(strict, "implicit_euler").refusal == "misses the error target");
  CHECK(*trial_of(strict, "implicit_euler").error_m > 1e-3);
  CHECK(*trial_of(strict, "implicit_euler").step_ms < *trial_of(strict, "velocity_verlet").step_ms);
  CHECK(scene::describe(loose.method) == "implicit_euler");
}

TEST_CASE("Very stiff springs are left to the implicit method", "[method_choice]") {
  scene::SceneDescription scene = swinging_chain(1e9);
  REQUIRE(stable_step_s(load_of(scene::build_world(scene))) < 1e-5);
  scene.error_target_m = 0.2;

  CHECK(scene::describe(choose(scene).method).starts_with("implicit_euler"));
}

TEST_CASE("No clock is read: a choice repeats to the bit", "[method_choice]") {
  const MethodChoice once = choose(swinging_chain()), again = choose(swinging_chain());

  CHECK(once.method == again.method);
  REQUIRE(once.trials.size() == again.trials.size());
  for (std::size_t i = 0; i < once.trials.size(); ++i) {
    CHECK(once.trials[i].step_ms == again.trials[i].step_ms);
    CHECK(once.trials[i].error_m == again.trials[i].error_m);
  }
}

TEST_CASE("A pendulum that auto chooses for keeps below the height that it began at",
          "[method_choice]") {
  // A rod of 0.4 m on a pin, let go at 50 degrees; BDF2 once took it over the top.
  constexpr double kLength_m = 0.4, kAngle_rad = 50.0 * std::numbers::pi / 180.0;
  const Eigen::Vector3d pin_m(0, 0, 0);
  bodies::BodyDescription rod =
      sim_server::box({0, 0, 0}, {0.02, 0.02, kLength_m}, 0.1, {0.02, 0.01});
  rod.orientation = Eigen::AngleAxisd(kAngle_rad, Eigen::Vector3d::UnitY());
  rod.position_m = pin_m - rod.orientation * Eigen::Vector3d(0, 0, 0.5 * kLength_m);
  scene::SceneDescription scene = joined_scene({rod}, {joint(0, -1, {pin_m}, 2000.0, 0.0)}, 9.81);
  scene.period_s = 0.01;
  scene.error_target_m = 0.005;
  scene.method = choose(scene).method;
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

TEST_CASE("A scene where nothing is free has a choice too", "[method_choice]") {
  const MethodChoice choice = choose(sim_server::scene_of({sim_server::floor_at(0.0)}));

  CHECK(choice.keeps_rate);
  CHECK(choice.meets_target);
  CHECK(std::count_if(choice.trials.begin(), choice.trials.end(),
                      [](const MethodTrial& trial) { return trial.refusal.empty(); }) == 1);
}

TEST_CASE("A scene is fit for the haptic rate when a step of 1 ms costs little of it",
          "[method_choice]") {
  CHECK(choose(swinging_chain()).fits_haptic_rate);

  const MethodChoice heavy = choose(sim_server::scene_of(
      {sim_server::sheet({60, 60}, 0.01, 1e-4, 1e5)}, sim_server::material_of(100.0)));
  CHECK(heavy.haptic_ms > kHapticShare);
  CHECK_FALSE(heavy.fits_haptic_rate);
}

TEST_CASE("The predicted limit of stability is that of the oscillator", "[method_choice]") {
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

}  // namespace
}  // namespace stillgrid::dynamics::method_choice_test
