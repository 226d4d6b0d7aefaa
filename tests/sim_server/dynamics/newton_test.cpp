#include "sim_server/dynamics/newton.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "sim_server/dynamics/implicit_euler.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid {
namespace {

/// A u + strength u^3 = b with a chain for A: smooth, with one solution.
class CubicChain : public NonlinearSystem {
 public:
  explicit CubicChain(double strength) : strength_(strength) {}
  Eigen::Index size() const override { return kSize; }
  void residual(const Eigen::VectorXd& u, Eigen::VectorXd& residual) override {
    ++residuals_;
    at_ = u;
    for (Eigen::Index i = 0; i < kSize; ++i) {
      const double left = i > 0 ? u[i - 1] : 0.0, right = i + 1 < kSize ? u[i + 1] : 0.0;
      residual[i] = 2.0 * u[i] - left - right + strength_ * u[i] * u[i] * u[i] - 1.0;
    }
  }
  void jacobian(Slope, Eigen::SparseMatrix<double>& matrix) override {
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(kSize, kSize);
    for (Eigen::Index i = 0; i < kSize; ++i) {
      dense(i, i) = 2.0 + 3.0 * strength_ * at_[i] * at_[i];
      if (i > 0) dense(i, i - 1) = dense(i - 1, i) = -1.0;
    }
    matrix = dense.sparseView();
  }
  const Eigen::VectorXd& residual_scale() const override { return scale_; }
  int residuals() const { return residuals_; }

 private:
  static constexpr Eigen::Index kSize = 8;
  double strength_;
  int residuals_ = 0;
  Eigen::VectorXd at_;
  Eigen::VectorXd scale_ = Eigen::VectorXd::Ones(kSize);
};

/// Residuals after 0, 1, 2, ... iterations.
std::vector<double> residuals_by_iteration(int iterations) {
  std::vector<double> residuals;
  for (int i = 0; i <= iterations; ++i) {
    CubicChain system(1.0);
    Eigen::VectorXd u = Eigen::VectorXd::Ones(system.size());
    residuals.push_back(
        NewtonSolver({.tolerance = 1e-15, .max_iterations = i}).solve(system, u).residual);
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

  const SolveReport first = NewtonSolver().solve(system, u);
  const SolveReport second = NewtonSolver().solve(system, u);

  CHECK(first.converged);
  CHECK(first.iterations == 1);
  CHECK(second.converged);
  CHECK(second.iterations == 0);
  for (Eigen::Index i = 0; i < u.size(); ++i)  // the parabola through both ends
    CHECK(u[i] == Approx(0.5 * double(i + 1) * double(8 - i)));
}

TEST_CASE("A solve cut short says so, and by how much", "[newton]") {
  CubicChain system(1.0);
  Eigen::VectorXd u = Eigen::VectorXd::Ones(system.size());

  const SolveReport report = NewtonSolver({.max_iterations = 1}).solve(system, u);

  CHECK_FALSE(report.converged);
  CHECK(report.iterations == 1);
  Eigen::VectorXd residual(u.size());
  system.residual(u, residual);
  CHECK(report.residual == Approx(residual.norm() / std::sqrt(8.0)));
  CHECK(report.residual > 1e-8);
}

TEST_CASE("A system that is no number is not called solved", "[newton]") {
  CubicChain system(std::numeric_limits<double>::quiet_NaN());
  Eigen::VectorXd u = Eigen::VectorXd::Ones(system.size());

  CHECK_FALSE(NewtonSolver().solve(system, u).converged);
}

TEST_CASE("Nothing to solve is solved", "[newton]") {
  const World world = build_world(scene_of({floor_at(0.0)}));
  ImplicitEulerStep step(world, {}, 0.01);
  Eigen::VectorXd u = step.initial_guess();

  const SolveReport report = NewtonSolver().solve(step, u);

  CHECK(report.converged);
  CHECK(report.iterations == 0);
  CHECK(report.residual == 0.0);
}

TEST_CASE("The tolerance bounds the error of the velocities", "[newton]") {
  SceneDescription scene =
      scene_of({thread(11, {0, 0, 0}, {1, 0, 0}, 0.01, 200.0, {0})}, {}, {0.0, 0.0, -9.81});
  const World world = build_world(scene);
  const auto velocities = [&](double tolerance) {
    ImplicitEulerStep step(world, {}, 0.02);
    Eigen::VectorXd u = step.initial_guess();
    REQUIRE(NewtonSolver({.tolerance = tolerance, .max_iterations = 100}).solve(step, u).converged);
    return u;
  };
  const Eigen::VectorXd reference = velocities(1e-13);

  // The residual over the mass; a taut chain resists at least as much as its inertia.
  for (const double tolerance : {1e-2, 1e-4, 1e-8})
    CHECK((velocities(tolerance) - reference).norm() / std::sqrt(30.0) <= 1.01 * tolerance);
}

}  // namespace
}  // namespace stillgrid
