#pragma once

#include <memory>

#include "sim_server/dynamics/solvers/linear_solver.hpp"
#include "sim_server/scene/method.hpp"

namespace stillgrid::dynamics {

/// Newton's method, safeguarded; the kind decides which Jacobian its steps follow first:
///   kNewton, kNewtonCg: the symmetric one, or where that is not positive definite the definite
///     one, as far along as the residual still works against the step: for a system with a
///     potential that is a descent, so it passes saddles and the kinks of contacts that come and
///     go. If a whole step leaves much of the residual, as where friction couples strongly, and now
///     and then, a step by the exact Jacobian is tried.
///   kNewtonLu, kNewtonBicgstab: the exact one. Its step is kept if it at least halves the
///     residual; otherwise one by the definite Jacobian is taken.
/// kNewton and kNewtonLu factorise; the others form no matrix, and solve each step no more
/// accurately than its residual asks for [Eisenstat, Walker 1996].
class NewtonSolver : public NonlinearSolver {
 public:
  /// tolerance: of the scaled residual, rms. Pre: kind is one of the above.
  NewtonSolver(const scene::SolverKind& kind, double tolerance);
  SolveReport solve(NonlinearSystem& system, Eigen::VectorXd& u, Budget& budget) override;

 private:
  bool exact_step(NonlinearSystem& system, Eigen::VectorXd& u, const Budget& budget);
  bool descent_step(NonlinearSystem& system, Eigen::VectorXd& u, const Budget& budget);
  bool load_trial(NonlinearSystem& system, const Eigen::VectorXd& u, double length);
  void take_trial(Eigen::VectorXd& u);

  bool exact_first_;
  double tolerance_;
  std::unique_ptr<LinearSolver> linear_solver_;
  double error_ = 0.0, trial_error_ = 0.0, accuracy_ = 0.0;
  double length_ = 1.0;  // of the last step by a symmetric Jacobian, as a share of Newton's
  Eigen::VectorXd residual_, trial_, trial_residual_, step_, best_;
};

}  // namespace stillgrid::dynamics
