#include "sim_server/dynamics/solvers/newton.hpp"

#include <Eigen/IterativeLinearSolvers>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "sim_server/dynamics/forces/implicit_stage.hpp"
#include "sim_server/dynamics/solvers/newton.hpp"
#include "tests/sim_server/contact/all_contacts.hpp"
#include "tests/sim_server/dynamics/cubic_chain.hpp"
#include "tests/sim_server/dynamics/dense_jacobian.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::newton_test {
namespace {

constexpr double kTolerance = 1e-8;

SolveReport solve(NonlinearSystem& system, Eigen::VectorXd& u, int iterations = 15,
                  double tolerance = kTolerance) {
  Budget budget{.iterations = iterations};
  return NewtonSolver(tolerance).solve(system, u, budget);
}

/// Residuals after 0, 1, 2, ... iterations.
std::vector<double> residuals_by_iteration(int iterations) {
  std::vector<double> residuals;
  for (int i = 0; i <= iterations; ++i) {
    CubicChain system(1.0);
    Eigen::VectorXd u = Eigen::VectorXd::Ones(system.size());
    residuals.push_back(solve(system, u, i, 1e-15).residual);
  }
  return residuals;
}

TEST_CASE("On a smooth system each iteration squares the error", "[newton]") {
  const std::vector<double> residuals = residuals_by_iteration(6);

  REQUIRE(residuals.front() > 0.1);
  int squared = 0;
  for (std::size_t i = 1; i < residuals.size(); ++i) {
    if (residuals[i - 1] > 1e-2 || residuals[i] < 1e-14) continue;
    CHECK(residuals[i] < 2.0 * residuals[i - 1] * residuals[i - 1]);
    ++squared;
  }
  CHECK(squared >= 2);
  CHECK(residuals.back() < 1e-14);
}

TEST_CASE("A linear system takes one iteration, a solved one none", "[newton]") {
  CubicChain system(0.0);
  Eigen::VectorXd u = Eigen::VectorXd::Zero(system.size());

  const SolveReport first = solve(system, u);
  const SolveReport second = solve(system, u);

  CHECK(first.converged);
  CHECK(first.iterations == 1);
  CHECK(second.converged);
  CHECK(second.iterations == 0);
  for (Eigen::Index i = 0; i < u.size(); ++i)  // the parabola through both ends
    CHECK(u[i] == Approx(0.5 * double(i + 1) * double(9 - i)));
}

/// A box sunk into the floor, sliding and tumbling: Coulomb friction under nine spheres.
bodies::World sliding_box() {
  bodies::BodyDescription block =
      sim_server::box({0, 0, 0.0195}, {0.03, 0.03, 0.04}, 0.02, {0.01, 0.005});
  return scene::build_world(sim_server::scene_of(
      {sim_server::moving(block, {0.4, 0.1, -0.1}, {0.5, 1.0, 2.0}), sim_server::floor_at(0.0)},
      sim_server::material_of(5e3, 0.25, 0.5), {0, 0, -9.81}));
}

TEST_CASE(
    "Conjugate gradients fail on Coulomb friction's exact slope; the solver, which lags friction, "
    "does not",
    "[newton]") {
  const bodies::World world = sliding_box();
  const std::vector<contact::Contact> contacts = contact::contacts_within(world, 0.01);
  MechanicalSystem system(world, contacts);
  ImplicitStage step(system, 0.01);
  Eigen::VectorXd u = step.initial_guess(), residual(u.size());
  step.residual(u, residual);
  REQUIRE(system.trial().touching == 9);
  const Eigen::MatrixXd exact = dense_jacobian(step, JacobianKind::kExact);
  CHECK((exact - exact.transpose()).norm() > 0.01 * exact.norm());
  Eigen::ConjugateGradient<Eigen::MatrixXd, Eigen::Lower | Eigen::Upper> gradients;
  gradients.setMaxIterations(600);  // a hundred times as many as a symmetric system needs
  gradients.compute(exact);
  const Eigen::VectorXd wrong = gradients.solve(residual);
  INFO("left of the residual: " << (exact * wrong - residual).norm() / residual.norm());
  CHECK_FALSE((exact * wrong - residual).norm() <= 1e-3 * residual.norm());

  const SolveReport report = solve(step, u, 40);
  INFO(report.residual << " after " << report.iterations);
  CHECK(report.converged);
}

TEST_CASE("A solve cut short says so, and by how much", "[newton]") {
  CubicChain system(1.0);
  Eigen::VectorXd u = Eigen::VectorXd::Ones(system.size());

  const SolveReport report = solve(system, u, 1);

  CHECK_FALSE(report.converged);
  CHECK(report.iterations == 1);
  Eigen::VectorXd residual(u.size());
  system.residual(u, residual);
  CHECK(report.residual == Approx(residual.norm() / std::sqrt(9.0)));
  CHECK(report.residual > 1e-8);
}

TEST_CASE("A system that is no number is not called solved", "[newton]") {
  CubicChain system(std::numeric_limits<double>::quiet_NaN());
  Eigen::VectorXd u = Eigen::VectorXd::Ones(system.size());

  CHECK_FALSE(solve(system, u).converged);
}

TEST_CASE("Nothing to solve is solved", "[newton]") {
  const bodies::World world = scene::build_world(sim_server::scene_of({sim_server::floor_at(0.0)}));
  MechanicalSystem system(world, {});
  ImplicitStage step(system, 0.01);
  Eigen::VectorXd u = step.initial_guess();

  const SolveReport report = solve(step, u);

  CHECK(report.converged);
  CHECK(report.iterations == 0);
  CHECK(report.residual == 0.0);
}

TEST_CASE("The tolerance bounds the error of the velocities", "[newton]") {
  scene::SceneDescription scene = sim_server::scene_of(
      {sim_server::thread(11, {0, 0, 0}, {1, 0, 0}, 0.01, 200.0, {0})}, {}, {0.0, 0.0, -9.81});
  const bodies::World world = scene::build_world(scene);
  const auto velocities = [&](double tolerance) {
    MechanicalSystem system(world, {});
    ImplicitStage step(system, 0.02);
    Eigen::VectorXd u = step.initial_guess();
    REQUIRE(solve(step, u, 100, tolerance).converged);
    return u;
  };
  const Eigen::VectorXd reference = velocities(1e-13);

  // The residual over the mass; a taut chain resists at least as much as its inertia.
  for (const double tolerance : {1e-2, 1e-4, 1e-8})
    CHECK((velocities(tolerance) - reference).norm() / std::sqrt(30.0) <= 1.01 * tolerance);
}

}  // namespace
}  // namespace stillgrid::dynamics::newton_test
