#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#include <chrono>
#include <vector>

#include "sim_server/dynamics/nonlinear_solver.hpp"

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
/// only when it changed.
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
  Eigen::SparseMatrix<double> matrix_;
  Pattern cholesky_pattern_, lu_pattern_;
  Eigen::SparseLU<Eigen::SparseMatrix<double>> lu_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> cholesky_;
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
