#include "tests/laboratory/methods/broyden.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "sim_server/scene/build_world.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "tests/laboratory/methods/laboratory_methods.hpp"
#include "tests/sim_server/dynamics/cubic_chain.hpp"
#include "tests/sim_server/dynamics/hanging_chain.hpp"
#include "tests/sim_server/dynamics/stopped_step.hpp"

namespace stillgrid::laboratory::broyden_test {
namespace {

/// Implicit Euler's stage, that remembers the largest residual asked of it.
class WatchedStage : public dynamics::ImplicitStage {
 public:
  using dynamics::ImplicitStage::ImplicitStage;
  void residual(const Eigen::VectorXd& u, Eigen::VectorXd& residual) override {
    dynamics::ImplicitStage::residual(u, residual);
    largest = std::max(largest, dynamics::scaled_rms(*this, residual));
  }
  double largest = 0.0;
};

struct LinearSolve {
  dynamics::SolveReport report;
  double growth = 0.0;  // of the residual, before it fell
};

/// Ten masses in a line under a pull along it, by springs of no rest length, which are linear: of
/// the thirty unknowns ten count.
LinearSolve solve_line(double stiffness) {
  constexpr double kStep_s = 0.01;
  bodies::World world = scene::build_world(sim_server::scene_of(
      {sim_server::thread(11, {0, 0, 0}, {1, 0, 0}, 1.0, stiffness / (kStep_s * kStep_s), {0})}, {},
      {1.0 / kStep_s, 0.0, 0.0}));
  for (bodies::Node& node : world.nodes) node.position_m.setZero();
  for (bodies::Spring& spring : world.springs) spring.rest_length_m = 0.0;
  dynamics::MechanicalSystem system(world, {});
  WatchedStage stage(system, kStep_s);
  Eigen::VectorXd u = stage.initial_guess(), first(u.size());
  stage.residual(u, first);
  dynamics::Budget budget{.iterations = 200};
  const dynamics::SolveReport report = BroydenSolver(1e-10).solve(stage, u, budget);
  return {report, stage.largest / dynamics::scaled_rms(stage, first)};
}

TEST_CASE("Broyden's method ends on a linear system in twice as many steps as unknowns",
          "[broyden]") {
  for (const double stiffness : {1.0, 100.0}) {  // k h^2 / m [Gay 1979]
    const LinearSolve solve = solve_line(stiffness);
    CHECK(solve.report.converged);
    CHECK(solve.report.iterations == 20);
  }
}

TEST_CASE("On the way to a linear system's solution the residual grows 80,000 times", "[broyden]") {
  const LinearSolve stiff = solve_line(100.0), stiffer = solve_line(1e4);

  CHECK(solve_line(1.0).growth == Approx(1.0));
  CHECK(stiff.growth == Approx(8e4).epsilon(0.05));
  CHECK(stiffer.growth > 1e7);  // so much that rounding takes a few steps more
  CHECK(stiffer.report.converged);
  CHECK(stiffer.report.iterations > 20);
  CHECK(stiffer.report.iterations < 30);
}

/// The table of the hanging chain (docs/cases.md, case 3.9).
struct Row {
  double stiffness;  // k h^2 / m
  double mean_iterations;
  int failures;
};

TEST_CASE("Broyden's method fails on stiff chains where Newton's does not", "[broyden]") {
  constexpr double kTolerance_m_s = 1e-10;
  const Row row =
      GENERATE(Row{2.0 / 9.0, 14.7, 0}, Row{20.0 / 9.0, 34.9, 0}, Row{200.0 / 9.0, 169.7, 6},
               Row{2000.0 / 9.0, 200.0, 40}, Row{20000.0 / 9.0, 200.0, 40});
  BroydenSolver broyden(kTolerance_m_s);
  dynamics::NewtonSolver newton(kTolerance_m_s);

  const dynamics::ChainSolves found =
      dynamics::solve_hanging_chain(broyden, row.stiffness, kTolerance_m_s);
  const dynamics::ChainSolves reference =
      dynamics::solve_hanging_chain(newton, row.stiffness, kTolerance_m_s);

  CHECK(found.mean_iterations == Approx(row.mean_iterations).epsilon(0.2));
  CHECK(std::abs(found.failures - row.failures) <= 4);
  CHECK(reference.failures == 0);
  CHECK(reference.mean_iterations < 10.0);
}

TEST_CASE("Where a stiff contact sets in, Broyden's method takes 16, 151 and over 500 steps",
          "[broyden]") {
  BroydenSolver broyden(1e-8);
  dynamics::NewtonSolver newton(1e-8);

  CHECK(dynamics::solve_contact_onset(broyden, 10.0, 1000).iterations == 16);
  CHECK(dynamics::solve_contact_onset(broyden, 100.0, 1000).iterations == 151);
  CHECK_FALSE(dynamics::solve_contact_onset(broyden, 1e4, 500).converged);
  for (const double stiffness : {10.0, 100.0, 1e4}) {
    const dynamics::SolveReport report = dynamics::solve_contact_onset(newton, stiffness, 15);
    CHECK(report.converged);
    CHECK(report.iterations <= 3);
  }
}

TEST_CASE("Cut short, Broyden's method returns the best it saw", "[broyden]") {
  // The residual grows first, so the best of few iterates is the first guess.
  dynamics::CubicChain system(1000.0);
  const Eigen::VectorXd guess = Eigen::VectorXd::Ones(system.size());
  Eigen::VectorXd u = guess, residual(u.size());
  system.residual(u, residual);
  const double first = dynamics::scaled_rms(system, residual);
  dynamics::Budget budget{.iterations = 3};

  const dynamics::SolveReport report = BroydenSolver(1e-10).solve(system, u, budget);

  CHECK_FALSE(report.converged);
  CHECK(report.iterations == 3);
  CHECK(report.residual == first);
  CHECK(u == guess);
}

TEST_CASE("Broyden's method stops at what is no number", "[broyden]") {
  dynamics::CubicChain broken(std::numeric_limits<double>::quiet_NaN()), steep(1e60);
  Eigen::VectorXd u = Eigen::VectorXd::Ones(broken.size()), v = 1e40 * u;
  dynamics::Budget budget{.iterations = 1000};
  BroydenSolver solver(1e-10);

  CHECK_FALSE(solver.solve(broken, u, budget).converged);
  CHECK(budget.iterations == 1000);
  CHECK_FALSE(solver.solve(steep, v, budget).converged);
  CHECK(budget.iterations > 990);
  CHECK(v.allFinite());
}

TEST_CASE("A scene names Broyden's method in the laboratory alone", "[broyden]") {
  const auto method_of = [](scene::Integrators integrators) {
    return scene::read_scene("format = 2\n[simulation]\nintegrator = 'broyden'\n", "scene.toml",
                             integrators)
        .method;
  };
  CHECK(method_of(laboratory_methods()) == scene::Method{.integrator = kBroyden});
  CHECK_THROWS_AS(method_of(scene::kIntegrators), toml::SceneError);
}

TEST_CASE("A step by Broyden's method is stopped, and resumed, as the product's", "[broyden]") {
  dynamics::check_stopped_step({.integrator = kBroyden});
}

}  // namespace
}  // namespace stillgrid::laboratory::broyden_test
