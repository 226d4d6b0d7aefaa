#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "shared/dynamics/implicit_step.hpp"
#include "tests/shared/dynamics/engine_scenes.hpp"

namespace stillgrid::dynamics {

/// One step of implicit Euler after another, by a solver of its equations: an ImplicitStep.
template <class Solver>
class Steps {
 public:
  template <class... Arguments>
  Steps(const EngineScene& scene, double step_s, Arguments... arguments)
      : scene_(scene),
        step_s_(step_s),
        listing_(scene_.description),
        solver_(scene_.description, arguments...) {
    solver_.leave_out(Sleep(scene_.description));
  }
  /// Solves from a state.
  SolveFigures solve(const SceneState& state) {
    SolveFigures figures;
    listing_.list(state, step_s_);
    solver_.start(state, step_s_);
    solver_.restart(listing_);
    solver_.solve(figures, nullptr);
    return figures;
  }
  /// The state moves to the solution.
  void finish(SceneState& state) {
    std::vector<SpherePlace> places(scene_.description.spheres.size());
    solver_.finish(state, listing_, places);
  }
  [[nodiscard]] const Solver& solver() const { return solver_; }

 private:
  EngineScene scene_;
  double step_s_;
  ContactListing listing_;
  Solver solver_;
};

/// The same from no velocity.
template <class Solver>
class FromRest : public Solver {
 public:
  using Solver::Solver;
  void start(const SceneState& state, double step_s) override {
    Solver::start(state, step_s);
    std::fill(this->velocities_.begin(), this->velocities_.end(), Vector4());
  }
};

inline constexpr double kChainStep_s = 1.0 / 30.0, kOnsetStep_s = 0.01;

/// Ten masses of 10 g held level by one end, links of 0.1 m. stiffness: k h^2 / m.
[[nodiscard]] inline EngineScene hanging_chain(double stiffness) {
  constexpr double kMass_kg = 0.01;
  EngineScene scene;
  scene.with_gravity();
  for (int i = 0; i <= 10; ++i) {
    scene.add_node(kMass_kg, {0.1 * i, 0, 0}, i == 0);
    if (i > 0) scene.add_spring(i - 1, i, stiffness * kMass_kg / (kChainStep_s * kChainStep_s));
  }
  return scene;
}

/// How a solver fared on the steps of a chain.
struct ChainSolves {
  double mean_iterations = 0.0;
  int failures = 0;
};

/// The chain let go: 40 steps of implicit Euler, each solved from no velocity. The chain goes on by
/// Newton's solution, whatever the solver found.
template <class Solver>
[[nodiscard]] ChainSolves solve_hanging_chain(double stiffness, double tolerance_m_s) {
  constexpr int kSteps = 40;
  const EngineScene scene = hanging_chain(stiffness);
  Steps<FromRest<Solver>> solver(scene, kChainStep_s, tolerance_m_s);
  Steps<ImplicitStep> newton(scene, kChainStep_s, tolerance_m_s);
  SceneState state = scene.state;
  ChainSolves result;
  for (int step = 0; step < kSteps; ++step) {
    const SolveFigures figures = solver.solve(state);
    result.mean_iterations += static_cast<double>(figures.iterations) / kSteps;
    result.failures += figures.converged ? 0 : 1;
    newton.solve(state);
    newton.finish(state);
  }
  return result;
}

/// Solves a step of implicit Euler in which a ball of 0.1 kg meets the floor half way. It is the
/// hardest step for Broyden's method, which begins from the free flight's Jacobian, the mass.
/// stiffness: k h^2 / m.
template <class Solver, class... Options>
[[nodiscard]] SolveFigures solve_contact_onset(double stiffness, double tolerance_m_s,
                                               Options... options) {
  constexpr double kMass_kg = 0.1, kRadius_m = 0.05, kGap_m = 0.005;
  EngineScene scene;
  scene.description.materials[0] = {stiffness * kMass_kg / (kOnsetStep_s * kOnsetStep_s), 0.0, 0.0};
  scene.add_sphere(
      scene.add_rigid(kMass_kg, Eigen::Vector3d::Constant(1e-4), {0, 0, kRadius_m + kGap_m}),
      kRadius_m);
  scene.state.rigid_velocity_m_s[0] = Vector4(0, 0, -1);
  scene.state.is_here = {1};
  scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
  Steps<Solver> solver(scene, kOnsetStep_s, tolerance_m_s, options...);
  return solver.solve(scene.state);
}

}  // namespace stillgrid::dynamics
