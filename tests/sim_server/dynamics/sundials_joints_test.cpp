// What joints keep where an error is asked for in place of a step.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/sim_server/dynamics/joined.hpp"

namespace stillgrid::dynamics::sundials_joints_test {
namespace {

constexpr unsigned kSeeds = tests::kCut == 1 ? 2 : 1;

scene::Method drawn_method() {
  return {.integrator = scene::IntegratorKind::kCvodeBdf, .tolerance_m_s = GENERATE(1e-4, 1e-6)};
}

TEST_CASE("Joined free bodies keep momentum and spin as closely as asked", "[sundials]") {
  const scene::Method method = drawn_method();
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    scene::SceneDescription scene = drawn_chain(seed, 0.3, 0.0, false);
    scene.method = method;
    Simulation simulation(scene);
    const Eigen::Vector3d momentum = momentum_kg_m_per_s(simulation.world());
    const Eigen::Vector3d spin = angular_momentum_kg_m2_per_s(simulation.world());

    REQUIRE(advance(simulation, 0.005, 100));

    INFO(method.integrator.name << ", " << method.tolerance_m_s << ", seed " << seed);
    // Both methods keep what is linear but for what their solver leaves.
    CHECK((momentum_kg_m_per_s(simulation.world()) - momentum).norm() <
          2.0 * method.tolerance_m_s * momentum.norm());
    CHECK((angular_momentum_kg_m2_per_s(simulation.world()) - spin).norm() <
          100.0 * method.tolerance_m_s * spin.norm());
  }
}

TEST_CASE("Energy of joined bodies stays, and with dampers only falls, as closely as asked",
          "[sundials]") {
  scene::Method method = drawn_method();
  method.tolerance_m_s *= 0.1;  // of looser ones it says nothing
  const double damping_N_s_per_m = GENERATE(0.0, 0.3);
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    scene::SceneDescription scene = drawn_chain(seed, damping_N_s_per_m, 0.0, false);
    scene.method = method;
    Simulation simulation(scene);
    const double start_J = energies_of(simulation).total_J();
    double before_J = start_J, off_J = 0.0;
    int steps = 0;
    for (int i = 0; i < 100; ++i) {
      steps += simulation.step(0.005, no_tool).solve.iterations;
      const double now_J = energies_of(simulation).total_J();
      off_J =
          std::max(off_J, damping_N_s_per_m > 0.0 ? now_J - before_J : std::abs(now_J - start_J));
      before_J = now_J;
    }
    INFO(method.integrator.name << ", " << method.tolerance_m_s << ", seed " << seed);
    // A step errs by the tolerance, in m/s, of speeds near 0.2 m/s: by ten times that of the
    // energy. The errors of the first steps of each tick, which are of first order, add up.
    CHECK(off_J < 40.0 * steps * method.tolerance_m_s * start_J);
  }
}

TEST_CASE("A body that SUNDIALS moves hangs m g / k below its joint", "[sundials]") {
  const scene::Method method = drawn_method();
  const bool is_of_nodes = GENERATE(false, true);
  CHECK(hanging_share(method, is_of_nodes) == Approx(1.0).epsilon(method.tolerance_m_s));
}

TEST_CASE("A rod that SUNDIALS moves swings with the period of a physical pendulum", "[sundials]") {
  const scene::Method method = drawn_method();
  const bool is_hinge = GENERATE(false, true);
  constexpr double kStretch = 2e-4;  // of m g / k, on an arm of 0.1 m
  CHECK(swing_share(method, is_hinge) ==
        Approx(1.0).epsilon(kStretch + 10.0 * method.tolerance_m_s));
}

}  // namespace
}  // namespace stillgrid::dynamics::sundials_joints_test
