#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>

#include "sim_server/dynamics/nonlinear_solver.hpp"

namespace stillgrid {

/// Newton's method, safeguarded.
///
/// A step by the exact Jacobian (sparse LU, for friction and rotation make it unsymmetric) is kept
/// if it at least halves the residual. Otherwise the step follows the definite slope (sparse
/// Cholesky), as far along as the residual still works against it: for a system with a potential
/// that is a descent, so it passes saddles and the kinks of contacts that come and go.
class NewtonSolver : public NonlinearSolver {
 public:
  /// tolerance: of the scaled residual, rms.
  explicit NewtonSolver(double tolerance) : tolerance_(tolerance) {}
  SolveReport solve(NonlinearSystem& system, Eigen::VectorXd& u, Budget& budget) override;

 private:
  bool exact_step(NonlinearSystem& system, Eigen::VectorXd& u);
  bool definite_step(NonlinearSystem& system, Eigen::VectorXd& u);
  bool load_trial(NonlinearSystem& system, const Eigen::VectorXd& u, double length);

  double tolerance_;
  double error_ = 0.0, trial_error_ = 0.0;
  Eigen::SparseMatrix<double> matrix_;
  Eigen::SparseLU<Eigen::SparseMatrix<double>> lu_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> cholesky_;
  Eigen::VectorXd residual_, trial_, trial_residual_, step_, best_;
};

}  // namespace stillgrid
