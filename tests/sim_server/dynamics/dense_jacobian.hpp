#pragma once

#include <Eigen/Dense>

#include "sim_server/dynamics/solvers/nonlinear_solver.hpp"

namespace stillgrid::dynamics {

/// The Jacobian at the u of the last residual(), column by column.
[[nodiscard]] inline Eigen::MatrixXd dense_jacobian(NonlinearSystem& system, JacobianKind kind) {
  const Eigen::Index size = system.size();
  Eigen::MatrixXd matrix(size, size);
  Eigen::VectorXd column(size);
  system.linearise(kind);
  for (Eigen::Index i = 0; i < size; ++i) {
    system.multiply(Eigen::VectorXd::Unit(size, i), column);
    matrix.col(i) = column;
  }
  return matrix;
}

/// An iteration of Newton's method without any safeguard, to show where that leads. residual: of
/// the u that it had, evaluated last.
inline void plain_newton_step(NonlinearSystem& system, const Eigen::VectorXd& residual,
                              Eigen::VectorXd& u) {
  u -= dense_jacobian(system, JacobianKind::kExact).partialPivLu().solve(residual);
}

}  // namespace stillgrid::dynamics
