#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#include <memory>
#include <vector>

#include "sim_server/dynamics/solvers/nonlinear_solver.hpp"

namespace stillgrid::dynamics {

/// Solves Jacobian * step = residual, where the residual was evaluated last: a Newton step.
class LinearSolver {
 public:
  LinearSolver() = default;
  virtual ~LinearSolver() = default;
  LinearSolver(const LinearSolver&) = delete;
  LinearSolver& operator=(const LinearSolver&) = delete;
  LinearSolver(LinearSolver&&) = delete;
  LinearSolver& operator=(LinearSolver&&) = delete;

  /// accuracy: how much of the residual may be left, relative, by a solver that iterates. False if
  /// a symmetric Jacobian is not positive definite, an exact one singular, or the result no number.
  [[nodiscard]] virtual bool solve(NonlinearSystem& system, JacobianKind kind,
                                   const Eigen::VectorXd& residual, double accuracy,
                                   const Budget& budget, Eigen::VectorXd& step) = 0;
};

/// By sparse factors: LDL^T of the symmetric Jacobians, LU of the exact one. Their pattern is
/// analysed only when it changed. A long factorisation runs on a thread of its own, and is left to
/// itself, as if it had failed, when the budget is stopped: the library has no other way to leave
/// it.
class DirectLinearSolver : public LinearSolver {
 public:
  bool solve(NonlinearSystem& system, JacobianKind kind, const Eigen::VectorXd& residual,
             double accuracy, const Budget& budget, Eigen::VectorXd& step) override;

 private:
  /// Of a matrix, to know it again.
  struct Pattern {
    std::vector<int> outer, inner;
    bool take(const Eigen::SparseMatrix<double>& matrix);  // whether it was another
  };
  /// All that a factorisation touches, so that one nobody waits for can end by itself.
  struct Factors {
    Eigen::SparseMatrix<double> matrix;
    Pattern cholesky_pattern, lu_pattern;
    Eigen::SparseLU<Eigen::SparseMatrix<double>> lu;
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> cholesky;

    /// Whether the matrix has factors that a Newton step may be made of.
    bool factorise(JacobianKind kind);
  };
  [[nodiscard]] bool factorise(JacobianKind kind, const Budget& budget);

  std::shared_ptr<Factors> factors_ = std::make_shared<Factors>();
};

/// Without a matrix, by products with the Jacobian, preconditioned by its diagonal blocks:
/// conjugate gradients for the symmetric Jacobians, which find out where one is not definite, and
/// BiCGSTAB [van der Vorst 1992] for the exact one. What is reached when the deadline passes is the
/// step.
class KrylovLinearSolver : public LinearSolver {
 public:
  bool solve(NonlinearSystem& system, JacobianKind kind, const Eigen::VectorXd& residual,
             double accuracy, const Budget& budget, Eigen::VectorXd& step) override;

  /// Another residual by the Jacobian of the last solve(). Pre: that was true, and not of kExact.
  bool solve_another(NonlinearSystem& system, const Eigen::VectorXd& residual, double accuracy,
                     const Budget& budget, Eigen::VectorXd& step) {
    return conjugate_gradients(system, residual, accuracy, budget, step) && step.allFinite();
  }

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
};

}  // namespace stillgrid::dynamics
