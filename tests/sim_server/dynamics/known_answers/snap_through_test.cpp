#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>

#include "sim_server/dynamics/forces/implicit_stage.hpp"
#include "sim_server/dynamics/solvers/newton.hpp"
#include "tests/sim_server/dynamics/dense_jacobian.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::snap_through_test {
namespace {

constexpr double kHalfSpan_m = 0.1, kHeight_m = 0.03, kStiffness_N_per_m = 1000.0, kMass_kg = 0.1;

/// Two bars that lean on each other, loaded at the top by its weight.
bodies::World truss(double load_N) {
  bodies::World world = scene::build_world(
      sim_server::scene_of({sim_server::thread(3, {-kHalfSpan_m, 0, 0}, {kHalfSpan_m, 0, 0},
                                               kMass_kg, kStiffness_N_per_m, {0, 2})},
                           {}, {0, 0, -load_N / kMass_kg}));
  world.nodes[1].position_m.z() = kHeight_m;
  for (bodies::Spring& bar : world.springs) bar.rest_length_m = std::hypot(kHalfSpan_m, kHeight_m);
  return world;
}

/// The greatest load that it bears, and the height at which it does.
struct Limit {
  double height_m, load_N;
};
Limit limit() {
  const double length_m = std::hypot(kHalfSpan_m, kHeight_m), b2 = kHalfSpan_m * kHalfSpan_m;
  const double height_m = std::sqrt(std::pow(length_m * b2, 2.0 / 3.0) - b2);
  return {height_m, 2.0 * kStiffness_N_per_m * height_m *
                        (length_m / std::hypot(kHalfSpan_m, height_m) - 1.0)};
}

constexpr double kStep_s = 100.0;  // so long that nothing but statics is left

/// Iterations of undamped Newton to the tolerance of a tenth of a nanometre a second; 200: none.
int plain_iterations(const bodies::World& world) {
  MechanicalSystem system(world, {});
  ImplicitStage step(system, kStep_s);
  Eigen::VectorXd u = Eigen::VectorXd::Zero(3), residual(3);
  for (int i = 0; i < 200; ++i) {
    step.residual(u, residual);
    if (scaled_rms(step, residual) < 1e-8) return i;
    plain_newton_step(step, residual, u);
  }
  return 200;
}

TEST_CASE("A shallow truss bears 0.994992 N, at a height of 17.0712 mm", "[known_answers]") {
  CHECK(std::abs(limit().height_m - 0.0170712) < 5e-8);
  CHECK(std::abs(limit().load_N - 0.994992) < 5e-7);
}

TEST_CASE(
    "Beyond its limit a truss snaps through to -34.9349 mm, by fewer iterations than plain "
    "Newton takes",
    "[known_answers]") {
  const bodies::World world = truss(1.01 * limit().load_N);
  MechanicalSystem system(world, {});
  ImplicitStage step(system, kStep_s);
  Eigen::VectorXd u = Eigen::VectorXd::Zero(3);
  Budget budget{.iterations = 100};

  const SolveReport report = NewtonSolver(1e-8).solve(step, u, budget);

  CHECK(report.converged);
  CHECK(std::abs(system.trial().nodes[1].position_m.z() - -0.0349349) < 5e-8);
  INFO("plain " << plain_iterations(world) << ", ours " << report.iterations);
  CHECK(report.iterations < plain_iterations(world));
}

}  // namespace
}  // namespace stillgrid::dynamics::snap_through_test
