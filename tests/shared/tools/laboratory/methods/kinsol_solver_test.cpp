#include "shared/tools/laboratory/methods/kinsol_solver.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "tests/sim_server/dynamics/cubic_chain.hpp"
#include "tests/sim_server/dynamics/hanging_chain.hpp"

namespace stillgrid::laboratory::kinsol_solver_test {
namespace {

constexpr KinsolStrategy kKrylov = KinsolStrategy::kNewtonKrylov,
                         kAnderson = KinsolStrategy::kAnderson;

TEST_CASE("KINSOL finds the solution that Newton's method finds", "[kinsol]") {
  dynamics::CubicChain system(1.0);
  Eigen::VectorXd expected = Eigen::VectorXd::Ones(system.size());
  dynamics::Budget plenty{.iterations = 100};
  REQUIRE(dynamics::NewtonSolver(scene::SolverKind::kNewton, 1e-12)
              .solve(system, expected, plenty)
              .converged);

  for (const KinsolStrategy strategy : {kKrylov, kAnderson}) {
    Eigen::VectorXd u = Eigen::VectorXd::Ones(system.size());
    dynamics::Budget budget{.iterations = 100};
    KinsolSolver solver(strategy, 1e-10);
    const dynamics::SolveReport report = solver.solve(system, u, budget);

    CHECK(report.converged);
    CHECK(report.iterations == 100 - budget.iterations);
    CHECK(report.iterations > 0);
    CHECK((u - expected).norm() < 1e-9);
    Eigen::VectorXd residual(u.size());
    system.residual(u, residual);
    CHECK(dynamics::scaled_rms(system, residual) ==
          report.residual);  // the tolerance is of the rms
    CHECK(solver.solve(system, u, budget).iterations == 0);
  }
}

TEST_CASE("KINSOL's Newton-Krylov solves chains of any stiffness", "[kinsol]") {
  const double stiffness = GENERATE(2.0 / 9.0, 200.0 / 9.0, 20000.0 / 9.0);
  KinsolSolver solver(kKrylov, 1e-8);

  const dynamics::ChainSolves result = dynamics::solve_hanging_chain(solver, stiffness, 1e-8);

  CHECK(result.failures == 0);
}

TEST_CASE("Anderson's acceleration solves soft chains and fails on stiff ones", "[kinsol]") {
  KinsolSolver solver(kAnderson, 1e-8);

  const dynamics::ChainSolves soft = dynamics::solve_hanging_chain(solver, 20.0 / 9.0, 1e-8);
  const dynamics::ChainSolves stiff = dynamics::solve_hanging_chain(solver, 20000.0 / 9.0, 1e-8);

  CHECK(soft.failures == 0);
  CHECK(soft.mean_iterations < 50.0);
  CHECK(stiff.failures == 40);
}

TEST_CASE("KINSOL's Newton-Krylov meets a stiff contact where it sets in", "[kinsol]") {
  for (const double stiffness : {10.0, 1e4}) {
    KinsolSolver solver(kKrylov, 1e-8);
    const dynamics::SolveReport report = dynamics::solve_contact_onset(solver, stiffness, 50);
    CHECK(report.converged);
  }
}

TEST_CASE("KINSOL stops when its budget is spent, at the best iterate", "[kinsol]") {
  const KinsolStrategy strategy = GENERATE(kKrylov, kAnderson);
  dynamics::CubicChain system(1.0);
  Eigen::VectorXd u = Eigen::VectorXd::Ones(system.size()), residual(u.size());
  system.residual(u, residual);
  const double first = dynamics::scaled_rms(system, residual);
  KinsolSolver solver(strategy, 1e-12);

  dynamics::Budget few{.iterations = 2};
  const dynamics::SolveReport report = solver.solve(system, u, few);
  CHECK_FALSE(report.converged);
  CHECK(report.iterations == 2);
  CHECK(report.residual < first);

  dynamics::Budget late{.deadline = std::chrono::steady_clock::now()};
  CHECK_FALSE(solver.solve(system, u, late).converged);
}

/// Breaks at its third residual.
class BreakingChain : public dynamics::CubicChain {
 public:
  using dynamics::CubicChain::CubicChain;
  void residual(const Eigen::VectorXd& u, Eigen::VectorXd& residual) override {
    if (++asked_ == 3) throw std::runtime_error("the third");
    dynamics::CubicChain::residual(u, residual);
  }

 private:
  int asked_ = 0;
};

TEST_CASE("What a system throws passes through KINSOL", "[kinsol]") {
  const KinsolStrategy strategy = GENERATE(kKrylov, kAnderson);
  BreakingChain system(1.0);
  Eigen::VectorXd u = Eigen::VectorXd::Ones(system.size());
  dynamics::Budget budget{.iterations = 100};

  CHECK_THROWS_WITH(KinsolSolver(strategy, 1e-10).solve(system, u, budget), "the third");
}

TEST_CASE("KINSOL does not call solved what is no number", "[kinsol]") {
  const KinsolStrategy strategy = GENERATE(kKrylov, kAnderson);
  dynamics::CubicChain broken(std::numeric_limits<double>::quiet_NaN());
  Eigen::VectorXd u = Eigen::VectorXd::Ones(broken.size());
  dynamics::Budget budget{.iterations = 100};

  CHECK_FALSE(KinsolSolver(strategy, 1e-10).solve(broken, u, budget).converged);
}

}  // namespace
}  // namespace stillgrid::laboratory::kinsol_solver_test
