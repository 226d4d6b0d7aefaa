#include "sim_server/dynamics/choice/method_choice.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "sim_server/dynamics/choice/predicted_cost.hpp"
#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::method_choice_test {
namespace {

/// A clock on which a step of each method takes what the test says, s; others take one second.
class PricedClock {
 public:
  explicit PricedClock(std::map<std::string, double> step_s) : step_s_(std::move(step_s)) {}

  MethodChoice choose(const scene::SceneDescription& scene) {
    return choose_method(
        scene,
        [this] {
          const auto price = step_s_.find(trying_);
          is_end_ = !is_end_;
          if (is_end_) now_s_ += price == step_s_.end() ? 1.0 : price->second;
          return now_s_;
        },
        [this](const std::string& line) {
          const std::string trying = "trying ";
          trying_ = line.rfind(trying, 0) == 0 ? line.substr(trying.size()) : "";
        });
  }

 private:
  std::map<std::string, double> step_s_;
  std::string trying_;
  double now_s_ = 0.0;
  bool is_end_ = true;  // of a step: the clock is asked at its start and at its end
};

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
  scene.error_target_m = 0.2;
  const MethodChoice dear =
      PricedClock({{"velocity_verlet", 0.008}, {"bdf2, newton", 0.004}}).choose(scene);
  const MethodChoice cheap =
      PricedClock({{"velocity_verlet", 0.001}, {"bdf2, newton", 0.004}}).choose(scene);

  CHECK(scene::describe(dear.method) == "bdf2, newton");
  CHECK(scene::describe(cheap.method) == "velocity_verlet");
  CHECK(cheap.meets_target);
}

TEST_CASE("What misses the error target is refused however cheap it is", "[method_choice]") {
  scene::SceneDescription scene = swinging_chain();
  PricedClock clock({{"implicit_euler, newton", 1e-6}, {"velocity_verlet", 0.001}});

  scene.error_target_m = 1e-3;
  const MethodChoice strict = clock.choose(scene);
  scene.error_target_m = 1.0;
  const MethodChoice loose = clock.choose(scene);

  CHECK(scene::describe(strict.method) == "velocity_verlet");
  CHECK(trial_of(strict, "implicit_euler, newton").refusal == "misses the error target");
  CHECK(*trial_of(strict, "implicit_euler, newton").error_m > 1e-3);
  CHECK(scene::describe(loose.method) == "implicit_euler, newton");
}

TEST_CASE("What misses the rate is refused however accurate it is", "[method_choice]") {
  scene::SceneDescription scene = swinging_chain();
  scene.error_target_m = 1e-3;
  const MethodChoice choice =
      PricedClock({{"velocity_verlet", 0.019}, {"implicit_euler, newton", 0.001}}).choose(scene);

  CHECK(scene::describe(choice.method) == "implicit_euler, newton");
  CHECK_FALSE(choice.meets_target);
  CHECK_FALSE(trial_of(choice, "velocity_verlet").refusal.empty());
}

TEST_CASE("Of very stiff springs the explicit method is not even tried", "[method_choice]") {
  const scene::SceneDescription scene = swinging_chain(1e9);
  REQUIRE(symplectic_limit_s(load_of(scene::build_world(scene))) < 1e-5);

  const MethodChoice choice =
      PricedClock({{"implicit_euler, newton", 0.001}, {"velocity_verlet", 1e-9}}).choose(scene);

  CHECK_FALSE(scene::is_explicit(choice.method.integrator));
  CHECK_FALSE(trial_of(choice, "velocity_verlet").measured_ms);
}

TEST_CASE("Every method is either tried or refused with a reason", "[method_choice]") {
  const MethodChoice choice = PricedClock({}).choose(swinging_chain());

  const auto some = [&](const auto& wanted) {
    return std::any_of(choice.trials.begin(), choice.trials.end(),
                       [&](const MethodTrial& trial) { return wanted(trial.method); });
  };
  for (const scene::IntegratorKind& kind : scene::kIntegrators)
    CHECK(some([&](const scene::Method& m) { return m.integrator == kind; }));
  for (const scene::SolverKind& kind : scene::kSolvers)
    CHECK(some([&](const scene::Method& m) { return m.solver == kind; }));
  const auto chosen = std::count_if(choice.trials.begin(), choice.trials.end(),
                                    [](const MethodTrial& trial) { return trial.refusal.empty(); });
  CHECK(chosen == 1);
}

/// Every method that is named of a scene.
std::set<std::string> tried_of(const scene::SceneDescription& scene) {
  std::set<std::string> names;
  for (const MethodTrial& trial : PricedClock({}).choose(scene).trials)
    names.insert(scene::describe(trial.method));
  return names;
}

TEST_CASE("A scene where nothing is free has a choice too", "[method_choice]") {
  const MethodChoice choice =
      PricedClock({{"symplectic_euler", 1e-3}, {"velocity_verlet", 2e-3}, {"bdf2, newton", 3e-3}})
          .choose(sim_server::scene_of({sim_server::floor_at(0.0)}));

  CHECK(scene::describe(choice.method) == "symplectic_euler");
  CHECK(choice.keeps_rate);
  CHECK(choice.meets_target);
  std::set<std::string> tried;
  for (const MethodTrial& trial : choice.trials) {
    CAPTURE(scene::describe(trial.method));
    CHECK(tried.insert(scene::describe(trial.method)).second);
    CHECK((trial.method == choice.method) == trial.refusal.empty());
    if (trial.error_m) CHECK(*trial.error_m == 0.0);
  }
  CHECK(tried == tried_of(swinging_chain()));
}

TEST_CASE("A scene is fit for the haptic rate when a step of 1 ms takes little of it",
          "[method_choice]") {
  // The last line told before the haptic trial names whichever method was tried last.
  const MethodChoice slow = PricedClock({}).choose(swinging_chain());

  CHECK(slow.haptic_ms == Approx(1000.0));
  CHECK_FALSE(slow.fits_haptic_rate);
  const MethodChoice fast = choose_method(
      swinging_chain(), [] { return 0.0; }, [](const std::string&) {});
  CHECK(fast.haptic_ms == 0.0);
  CHECK(fast.fits_haptic_rate);
}

TEST_CASE("The predicted limit of stability is that of the oscillator", "[method_choice]") {
  // cases: a mass on one spring, w = sqrt(k / m) = 100 rad/s: 2 / w, and with zeta = 0.2 less.
  scene::SceneDescription scene =
      sim_server::scene_of({sim_server::thread(2, {0, 0, 0}, {0.1, 0, 0}, 0.1, 1000.0, {0})});
  const double free_s = symplectic_limit_s(load_of(scene::build_world(scene)));
  sim_server::springs(scene.bodies[0]).spring_damping_N_s_per_m =
      2.0 * 0.2 * std::sqrt(1000.0 * 0.1);
  const double damped_s = symplectic_limit_s(load_of(scene::build_world(scene)));

  CHECK(free_s == Approx(0.0200).epsilon(0.06));
  CHECK(damped_s == Approx(0.01640).epsilon(0.06));
}

}  // namespace
}  // namespace stillgrid::dynamics::method_choice_test
