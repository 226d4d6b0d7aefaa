#pragma once

#include <Eigen/Core>

#include "sim_server/dynamics/solvers/nonlinear_solver.hpp"

namespace stillgrid::dynamics {

/// Solves Jacobian * step = residual, where the residual was evaluated last: a Newton step. Forms
/// no matrix but multiplies by the Jacobian, preconditioned: conjugate gradients for the symmetric
/// Jacobians, BiCGSTAB [van der Vorst 1992] for the exact one. A solve that the deadline interrupts
/// returns the step reached so far.
class KrylovLinearSolver {
 public:
  /// accuracy: relative norm of the residual that may remain. Returns false if a symmetric Jacobian
  /// is not positive definite, an exact one is singular, or the result is not finite.
  [[nodiscard]] bool solve(NonlinearSystem& system, JacobianKind kind,
                           const Eigen::VectorXd& residual, double accuracy, const Budget& budget,
                           Eigen::VectorXd& step);

  /// Another residual by the Jacobian of the last solve(). Pre: that was true, and not of kExact.
  bool solve_another(NonlinearSystem& system, const Eigen::VectorXd& residual, double accuracy,
                     const Budget& budget, Eigen::VectorXd& step) {
    return conjugate_gradients(system, residual, accuracy, budget, step) && step.allFinite();
  }

  /// Products with the Jacobian that all solves have taken.
  [[nodiscard]] long products() const noexcept { return products_; }

 private:
  bool invert_blocks(const Eigen::Matrix3Xd& blocks);
  void precondition(const Eigen::VectorXd& x, Eigen::VectorXd& y) const;
  void multiply_split(NonlinearSystem& system, const Eigen::VectorXd& x);
  bool conjugate_gradients(NonlinearSystem& system, const Eigen::VectorXd& residual,
                           double accuracy, const Budget& budget, Eigen::VectorXd& step);
  bool bicgstab(NonlinearSystem& system, const Eigen::VectorXd& residual, double accuracy,
                const Budget& budget, Eigen::VectorXd& step);

  Eigen::Matrix3Xd inverse_;  // of the diagonal blocks
  Eigen::VectorXd rest_, search_, preconditioned_, product_, shadow_, second_, second_product_;
  Eigen::VectorXd solved_, left_, split_step_, unpadded_, rest_product_;
  long products_ = 0;
};

}  // namespace stillgrid::dynamics
