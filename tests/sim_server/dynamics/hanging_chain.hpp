#pragma once

#include <vector>

#include "sim_server/dynamics/integrators/implicit_stage.hpp"
#include "sim_server/dynamics/solvers/newton.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics {

/// How a solver fared on the steps of a chain.
struct ChainSolves {
  double mean_iterations = 0.0;
  int failures = 0;
};

/// Ten masses held level by one end, links of 0.1 m, let go: 40 steps of implicit Euler of 1/30 s,
/// each solved by `solver` from no velocity, in 200 iterations at most. The chain goes on by
/// Newton's solution, whatever the solver found. stiffness: k h^2 / m.
[[nodiscard]] inline ChainSolves solve_hanging_chain(NonlinearSolver& solver, double stiffness,
                                                     double tolerance_m_s) {
  constexpr double kMass_kg = 0.01, kStep_s = 1.0 / 30.0;
  constexpr int kMasses = 10, kSteps = 40, kMaxIterations = 200;
  bodies::World world = scene::build_world(sim_server::scene_of(
      {sim_server::thread(kMasses + 1, {0, 0, 0}, {0.1 * kMasses, 0, 0}, kMass_kg,
                          stiffness * kMass_kg / (kStep_s * kStep_s), {0})},
      {}, {0.0, 0.0, -9.81}));
  NewtonSolver newton(tolerance_m_s);
  ChainSolves result;
  for (int step = 0; step < kSteps; ++step) {
    MechanicalSystem system(world, {});
    ImplicitStage stage(system, kStep_s);
    Eigen::VectorXd u = Eigen::VectorXd::Zero(stage.size());
    Budget budget{.iterations = kMaxIterations};
    const SolveReport report = solver.solve(stage, u, budget);
    result.mean_iterations += static_cast<double>(report.iterations) / kSteps;
    result.failures += report.converged ? 0 : 1;

    u = stage.initial_guess();
    Budget plenty{.iterations = kMaxIterations};
    newton.solve(stage, u, plenty);
    world.nodes = system.trial().nodes;
  }
  return result;
}

/// A ball about to meet the floor within a step of implicit Euler, half way: what Broyden's method
/// from the free flight's Jacobian, the mass, finds hardest. stiffness: k h^2 / m.
[[nodiscard]] inline SolveReport solve_contact_onset(NonlinearSolver& solver, double stiffness,
                                                     int most_iterations) {
  constexpr double kMass_kg = 0.1, kRadius_m = 0.05, kStep_s = 0.01, kGap_m = 0.005;
  const bodies::World world = scene::build_world(sim_server::scene_of({sim_server::moving(
      sim_server::sphere({0, 0, kRadius_m + kGap_m}, kRadius_m, kMass_kg), {0, 0, -1})}));
  contact::Contact contact;
  contact.material.stiffness_N_per_m = stiffness * kMass_kg / (kStep_s * kStep_s);
  contact.material.slip_speed_m_s = 1e-3;
  contact.radius_a_m = kRadius_m;
  contact.depth_before_m = -kGap_m;
  contact.is_plane = true;
  contact.plane_normal = Eigen::Vector3d::UnitZ();
  const std::vector<contact::Contact> contacts{contact};
  MechanicalSystem system(world, contacts);
  ImplicitStage stage(system, kStep_s);
  Eigen::VectorXd u = stage.initial_guess();
  Budget budget{.iterations = most_iterations};
  return solver.solve(stage, u, budget);
}

}  // namespace stillgrid::dynamics
