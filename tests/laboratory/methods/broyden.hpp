#pragma once

#include <memory>
#include <vector>

#include "sim_server/dynamics/integrators/integrator.hpp"
#include "sim_server/dynamics/solvers/nonlinear_solver.hpp"
#include "sim_server/scene/method.hpp"

namespace stillgrid::laboratory {

/// Broyden's (first, "good") method [Hilde, Meseure, Chaillou 2001]: the first estimate of the
/// Jacobian is the mass diagonal. Every step corrects the estimate by a matrix of rank one, so a
/// system costs one residual an iteration and forms no matrix.
///
/// Full steps and no safeguard, as published: it converges slowly on stiff systems, or not at all
/// (docs/algorithms/broyden.md). It then returns the best iterate, as any solver here. The inverse
/// is kept as a product of rank-one factors in the steps themselves [Kelley 1995, section 7.3]:
/// iteration k costs k dot products and k vectors of memory.
class BroydenSolver : public dynamics::NonlinearSolver {
 public:
  /// tolerance: rms of the scaled residual at which it has converged.
  explicit BroydenSolver(double tolerance) : tolerance_(tolerance) {}
  dynamics::SolveReport solve(dynamics::NonlinearSystem& system, Eigen::VectorXd& u,
                              dynamics::Budget& budget) override;

 private:
  void find_step(const dynamics::NonlinearSystem& system, std::size_t taken);

  double tolerance_;
  std::vector<Eigen::VectorXd> steps_;  // memory is kept from one solve to the next
  std::vector<double> squares_;         // of their norms
  Eigen::VectorXd residual_, best_;
};

/// Implicit Euler solved by Broyden's method.
[[nodiscard]] std::unique_ptr<dynamics::Integrator> make_broyden(const scene::Method& method);
/// As a scene names it.
inline constexpr scene::IntegratorKind kBroyden{"broyden", scene::IntegratorFamily::kImplicit,
                                                make_broyden};

}  // namespace stillgrid::laboratory
