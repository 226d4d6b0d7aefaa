#pragma once

#include <Eigen/Dense>
#include <Eigen/SparseCore>

#include "sim_server/dynamics/solvers/nonlinear_solver.hpp"

namespace stillgrid::dynamics {

/// An iteration of Newton's method without any safeguard, to show where that leads. residual: of
/// the u that it had, evaluated last.
inline void plain_newton_step(NonlinearSystem& system, const Eigen::VectorXd& residual,
                              Eigen::VectorXd& u) {
  Eigen::SparseMatrix<double> exact;
  system.jacobian(JacobianKind::kExact, exact);
  u -= Eigen::MatrixXd(exact).partialPivLu().solve(residual);
}

}  // namespace stillgrid::dynamics
