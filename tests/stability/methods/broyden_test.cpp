#include "tests/laboratory/methods/broyden.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "sim_server/scene/scene_file.hpp"
#include "tests/laboratory/methods/laboratory_methods.hpp"
#include "tests/shared/dynamics/hanging_chain.hpp"
#include "tests/sim_server/dynamics/stopped_step.hpp"

namespace stillgrid::laboratory::broyden_test {
namespace {

constexpr double kTolerance_m_s = 1e-10;

/// Remembers the largest residual of its iterates.
class WatchedStep : public BroydenStep {
 public:
  using BroydenStep::BroydenStep;
  double first_m_s = 0.0, largest_m_s = 0.0;

 protected:
  void look(double residual_m_s) override {
    if (first_m_s == 0.0) first_m_s = residual_m_s;
    largest_m_s = std::max(largest_m_s, residual_m_s);
  }
};

struct LinearSolve {
  dynamics::SolveFigures figures;
  double growth = 0.0;  // of the residual, before it fell
};

/// Ten masses in a line under a pull along it, by springs of no rest length, which are linear: of
/// the thirty unknowns ten count.
LinearSolve solve_line(double stiffness) {
  constexpr double kStep_s = 0.01;
  dynamics::EngineScene scene;
  scene.description.gravity_m_s2 = {1.0 / kStep_s, 0.0, 0.0};
  for (int i = 0; i <= 10; ++i) {
    scene.add_node(1.0, {0, 0, 0}, i == 0);
    if (i > 0) scene.add_spring(i - 1, i, stiffness / (kStep_s * kStep_s));
  }
  dynamics::Steps<WatchedStep> steps(scene, kStep_s, kTolerance_m_s);
  const dynamics::SolveFigures figures = steps.solve(scene.state);
  return {figures, steps.solver().largest_m_s / steps.solver().first_m_s};
}

TEST_CASE("Broyden's method ends on a linear system in twice as many steps as unknowns",
          "[broyden]") {
  for (const double stiffness : {1.0, 100.0}) {  // k h^2 / m [Gay 1979]
    const LinearSolve solve = solve_line(stiffness);
    CHECK(solve.figures.converged);
    CHECK(solve.figures.iterations == 20);
  }
}

TEST_CASE("On the way to a linear system's solution the residual grows 80,000 times", "[broyden]") {
  const LinearSolve stiff = solve_line(100.0), stiffer = solve_line(1e4);

  CHECK(solve_line(1.0).growth == Approx(1.0));
  CHECK(stiff.growth == Approx(8e4).epsilon(0.05));
  CHECK(stiffer.growth > 1e7);  // so much that rounding takes a few steps more
  CHECK(stiffer.figures.converged);
  CHECK(stiffer.figures.iterations > 20);
  CHECK(stiffer.figures.iterations < 30);
}

/// The table of the hanging chain (docs/cases.md, case 3.9).
struct Row {
  double stiffness;  // k h^2 / m
  double mean_iterations;
  int failures;
};

TEST_CASE("Broyden's method fails on stiff chains where Newton's does not", "[broyden]") {
  const Row row =
      GENERATE(Row{2.0 / 9.0, 14.7, 0}, Row{20.0 / 9.0, 34.9, 0}, Row{200.0 / 9.0, 169.7, 6},
               Row{2000.0 / 9.0, 200.0, 40}, Row{20000.0 / 9.0, 200.0, 40});

  const dynamics::ChainSolves found =
      dynamics::solve_hanging_chain<BroydenStep>(row.stiffness, kTolerance_m_s);
  const dynamics::ChainSolves reference =
      dynamics::solve_hanging_chain<dynamics::ImplicitStep>(row.stiffness, kTolerance_m_s);

  INFO(row.stiffness << ": Newton's method takes " << reference.mean_iterations);
  CHECK(found.mean_iterations == Approx(row.mean_iterations).epsilon(0.2));
  CHECK(std::abs(found.failures - row.failures) <= 4);
  CHECK(reference.failures == 0);
  CHECK(reference.mean_iterations < 10.0);
}

TEST_CASE("Where a stiff contact sets in, Broyden's method takes 16, 151 and over 500 steps",
          "[broyden]") {
  const auto broyden = [](double stiffness, int most_iterations) {
    return dynamics::solve_contact_onset<BroydenStep>(stiffness, 1e-8, most_iterations);
  };
  CHECK(broyden(10.0, 1000).iterations == 16);
  CHECK(broyden(100.0, 1000).iterations == 151);
  CHECK_FALSE(broyden(1e4, 500).converged);
  for (const double stiffness : {10.0, 100.0, 1e4, 1e6}) {
    const dynamics::SolveFigures figures =
        dynamics::solve_contact_onset<dynamics::ImplicitStep>(stiffness, 1e-8);
    CHECK(figures.converged);
    CHECK(figures.iterations <= 3);
  }
}

TEST_CASE("Cut short, Broyden's method ends at the best it saw", "[broyden]") {
  // The residual grows first, so the best of few iterates is the first guess.
  const dynamics::EngineScene scene = dynamics::hanging_chain(2000.0 / 9.0);
  dynamics::Steps<WatchedStep> steps(scene, dynamics::kChainStep_s, kTolerance_m_s, 3);
  dynamics::SceneState state = scene.state;
  state.node_velocity_m_s[5] = dynamics::Vector4(1, 0, 0);  // so that a link stretches
  const std::vector<dynamics::Vector4> guess = state.node_velocity_m_s;

  const dynamics::SolveFigures figures = steps.solve(state);
  steps.finish(state);

  CHECK_FALSE(figures.converged);
  CHECK(figures.iterations == 3);
  CHECK(figures.residual_m_s == steps.solver().first_m_s);
  for (std::size_t i = 0; i < guess.size(); ++i)
    CHECK(state.node_velocity_m_s[i].vector() == guess[i].vector());
}

TEST_CASE("Broyden's method stops at what is no number", "[broyden]") {
  const dynamics::EngineScene scene = dynamics::hanging_chain(1.0);
  dynamics::Steps<BroydenStep> steps(scene, dynamics::kChainStep_s, kTolerance_m_s);
  dynamics::SceneState state = scene.state;
  state.node_velocity_m_s[5].x = std::numeric_limits<double>::quiet_NaN();

  const dynamics::SolveFigures figures = steps.solve(state);

  CHECK_FALSE(figures.converged);
  CHECK(figures.iterations == 0);
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
