#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#include <memory>
#include <vector>

#include "sim_server/dynamics/solvers/nonlinear_solver.hpp"

namespace stillgrid {

/// Solves slope * step = residual, where the residual was evaluated last: a Newton step.
class SlopeSolver {
 public:
  SlopeSolver() = default;
  virtual ~SlopeSolver() = default;
  SlopeSolver(const SlopeSolver&) = delete;
  SlopeSolver& operator=(const SlopeSolver&) = delete;
  SlopeSolver(SlopeSolver&&) = delete;
  SlopeSolver& operator=(SlopeSolver&&) = delete;

  /// accuracy: how much of the residual may be left, relative, by a solver that iterates. False if
  /// a symmetric slope is not positive definite, an exact one singular, or the result no number.
  [[nodiscard]] virtual bool solve(NonlinearSystem& system, Slope slope,
                                   const Eigen::VectorXd& residual, double accuracy,
                                   const Budget& budget, Eigen::VectorXd& step) = 0;
};

/// By sparse factors: LDL^T of the symmetric slopes, LU of the exact one. Their pattern is analysed
/// only when it changed. A long factorisation runs on a thread of its own, and is left to itself,
/// as if it had failed, when the budget is stopped: the library has no other way to leave it.
class FactorisedSlope : public SlopeSolver {
 public:
  bool solve(NonlinearSystem& system, Slope slope, const Eigen::VectorXd& residual, double accuracy,
             const Budget& budget, Eigen::VectorXd& step) override;

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
    bool factorise(Slope slope);
  };
  [[nodiscard]] bool factorise(Slope slope, const Budget& budget);

  std::shared_ptr<Factors> factors_ = std::make_shared<Factors>();
};

/// Without a matrix, by products with the slope, preconditioned by its diagonal blocks: conjugate
/// gradients for the symmetric slopes, which find out where one is not definite, and BiCGSTAB
/// [van der Vorst 1992] for the exact one. What is reached when the deadline passes is the step.
class MatrixFreeSlope : public SlopeSolver {
 public:
  bool solve(NonlinearSystem& system, Slope slope, const Eigen::VectorXd& residual, double accuracy,
             const Budget& budget, Eigen::VectorXd& step) override;

 private:
  bool invert_blocks(const Eigen::Matrix3Xd& blocks, bool definite);
  void precondition(const Eigen::VectorXd& x, Eigen::VectorXd& y) const;
  bool conjugate_gradients(NonlinearSystem& system, const Eigen::VectorXd& residual,
                           double accuracy, const Budget& budget, Eigen::VectorXd& step);
  bool bicgstab(NonlinearSystem& system, const Eigen::VectorXd& residual, double accuracy,
                const Budget& budget, Eigen::VectorXd& step);

  Eigen::Matrix3Xd inverse_;  // of the diagonal blocks
  Eigen::VectorXd rest_, search_, preconditioned_, product_, shadow_, second_, second_product_;
};

}  // namespace stillgrid
