#include "tests/sim_server/dynamics/stopped_step.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <stdexcept>

#include "sim_server/dynamics/choice/counted_work.hpp"

namespace stillgrid::dynamics::stopped_step_test {
namespace {

TEST_CASE("A step that is stopped leaves the world where it was, and takes it up again",
          "[stopped_step]") {
  const scene::Method methods[] = {
      {.integrator = scene::IntegratorKind::kVelocityVerlet, .substeps = 1'000'000},
      {},
      {.integrator = scene::IntegratorKind::kCvodeBdf}};
  const std::size_t index = GENERATE_COPY(range(std::size_t{0}, std::size(methods)));
  check_stopped_step(methods[index]);
}

TEST_CASE("As many substeps as are said to be stable are, a third of them are not",
          "[stopped_step]") {
  const auto energy_gain = [](double share) {
    scene::SceneDescription scene =
        hanging_sheet({.integrator = scene::IntegratorKind::kVelocityVerlet}, 5);
    scene.gravity_m_s2.setZero();
    scene.bodies[0].angular_velocity_rad_s = {0, 3, 1};  // so that springs stretch
    const int stable = stable_substeps(load_of(scene::build_world(scene)), 0.05);
    REQUIRE(stable > 4);
    scene.method.substeps = std::max(1, static_cast<int>(share * stable));
    Simulation simulation(scene);
    const double start_J = bodies::mechanical_energy_J(simulation.world());
    double most_J = start_J;
    try {
      for (int step = 0; step < 40 && most_J <= 10.0 * start_J; ++step) {
        (void)simulation.step(0.05, [] { return std::nullopt; });
        most_J = std::max(most_J, bodies::mechanical_energy_J(simulation.world()));
      }
    } catch (const std::domain_error&) {  // beyond a float's range
      return std::numeric_limits<double>::infinity();
    }
    return most_J / start_J;
  };
  CHECK(energy_gain(1.0) < 1.2);
  CHECK(energy_gain(0.33) > 10.0);  // the bound is from above
}

}  // namespace
}  // namespace stillgrid::dynamics::stopped_step_test
