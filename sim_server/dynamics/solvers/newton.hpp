#pragma once

#include "sim_server/dynamics/solvers/linear_solver.hpp"

namespace stillgrid::dynamics {

/// Newton's method, safeguarded. A step follows the symmetric Jacobian, or the definite one where
/// that is not positive definite, until the residual no longer works against the step. For a system
/// with a potential each step descends, so it passes saddles and the kinks of contacts that begin
/// and end. A step by the exact Jacobian is tried after slow steps, as where friction couples
/// strongly; it is kept if it at least halves the residual. Each step is solved no more accurately
/// than its residual asks for [Eisenstat, Walker 1996].
class NewtonSolver {
 public:
  /// tolerance: rms of the scaled residual at which it has converged.
  explicit NewtonSolver(double tolerance) : tolerance_(tolerance) {}
  /// Writes the solution to u, and leaves the system there. If no iterate is good enough, it takes
  /// the one of least residual. It counts down the iterations of the budget, and stops when that is
  /// spent.
  SolveReport solve(NonlinearSystem& system, Eigen::VectorXd& u, Budget& budget);

 private:
  bool exact_step(NonlinearSystem& system, Eigen::VectorXd& u, const Budget& budget);
  bool descent_step(NonlinearSystem& system, Eigen::VectorXd& u, const Budget& budget);
  bool load_trial(NonlinearSystem& system, const Eigen::VectorXd& u, double length);
  void take_trial(Eigen::VectorXd& u);

  double tolerance_;
  KrylovLinearSolver linear_solver_;
  double error_ = 0.0, trial_error_ = 0.0, accuracy_ = 0.0;
  double length_ = 1.0;  // of the last step by a symmetric Jacobian, as a share of Newton's
  Eigen::VectorXd residual_, trial_, trial_residual_, step_, best_;
};

}  // namespace stillgrid::dynamics
