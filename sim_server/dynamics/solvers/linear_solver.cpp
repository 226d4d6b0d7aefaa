#include "sim_server/dynamics/solvers/linear_solver.hpp"

#include <Eigen/LU>
#include <cmath>

namespace stillgrid::dynamics {
namespace {

int most_iterations(Eigen::Index size) {
  return static_cast<int>(2 * size) + 20;
}

/// Looks at the clock now and then only.
bool is_late(const Budget& budget, int iteration) {
  return budget.is_stopped() || (iteration % 16 == 15 && budget.is_late());
}

}  // namespace

bool KrylovLinearSolver::solve(NonlinearSystem& system, JacobianKind kind,
                               const Eigen::VectorXd& residual, double accuracy,
                               const Budget& budget, Eigen::VectorXd& step) {
  if (budget.is_stopped()) return false;
  system.linearise(kind);
  const bool solved = kind == JacobianKind::kExact
                          ? invert_blocks(system.block_diagonal()) &&
                                bicgstab(system, residual, accuracy, budget, step)
                          : system.triangle().factorise(system.block_diagonal()) &&
                                conjugate_gradients(system, residual, accuracy, budget, step);
  return solved && step.allFinite();
}

bool KrylovLinearSolver::invert_blocks(const Eigen::Matrix3Xd& blocks) {
  inverse_.resize(3, blocks.cols());
  for (Eigen::Index i = 0; i < blocks.cols(); i += 3) {
    const Eigen::Matrix3d block = blocks.middleCols<3>(i);
    const double determinant = block.determinant();
    if (determinant == 0.0 || !std::isfinite(determinant)) return false;
    inverse_.middleCols<3>(i) = block.inverse();
  }
  return true;
}

void KrylovLinearSolver::precondition(const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
  y.resize(x.size());
  for (Eigen::Index i = 0; i < x.size(); i += 3)
    y.segment<3>(i).noalias() = inverse_.middleCols<3>(i) * x.segment<3>(i);
}

/// product = (E + L)^-1 A (E + L^T)^-1 x, in two sweeps instead of a product and two sweeps.
void KrylovLinearSolver::multiply_split(NonlinearSystem& system, const Eigen::VectorXd& x) {
  const BlockTriangle& triangle = system.triangle();
  triangle.solve_upper(x, solved_, left_);
  if (system.has_rest()) {
    triangle.unpad(solved_, unpadded_);
    rest_product_.setZero(unpadded_.size());
    system.add_rest(unpadded_, rest_product_);
    triangle.add_unpadded(rest_product_, left_);
  }
  triangle.solve_lower(left_, product_);
  product_ += solved_;
  ++products_;
}

bool KrylovLinearSolver::conjugate_gradients(NonlinearSystem& system,
                                             const Eigen::VectorXd& residual, double accuracy,
                                             const Budget& budget, Eigen::VectorXd& step) {
  const BlockTriangle& triangle = system.triangle();
  triangle.pad(residual, left_);
  triangle.solve_lower(left_, rest_);
  split_step_.setZero(rest_.size());
  triangle.multiply_pivots(rest_, preconditioned_);
  search_ = preconditioned_;
  double rest2 = rest_.dot(preconditioned_);
  const double enough2 = accuracy * accuracy * rest2;
  const int most = most_iterations(residual.size());
  for (int i = 0; i < most && rest2 > enough2 && !is_late(budget, i); ++i) {
    multiply_split(system, search_);
    const double curvature = search_.dot(product_);
    if (!(curvature > 0.0)) return false;
    const double length = rest2 / curvature;
    split_step_ += length * search_;
    rest_ -= length * product_;
    triangle.multiply_pivots(rest_, preconditioned_);
    const double before2 = rest2;
    rest2 = rest_.dot(preconditioned_);
    search_ = preconditioned_ + rest2 / before2 * search_;
  }
  triangle.solve_upper(split_step_, solved_, left_);
  triangle.unpad(solved_, step);
  return true;
}

bool KrylovLinearSolver::bicgstab(NonlinearSystem& system, const Eigen::VectorXd& residual,
                                  double accuracy, const Budget& budget, Eigen::VectorXd& step) {
  const Eigen::VectorXd& scale = system.residual_scale();
  step.setZero(residual.size());
  if (residual.isZero(0.0)) return true;
  rest_ = residual;
  shadow_ = rest_.cwiseProduct(scale);  // the product's angles are those of velocities
  search_ = rest_;
  double angle = rest_.dot(shadow_);
  const double enough = accuracy * rest_.cwiseProduct(scale).norm();
  const int most = most_iterations(residual.size());
  for (int i = 0; i < most && !is_late(budget, i); ++i) {
    precondition(search_, preconditioned_);
    system.multiply(preconditioned_, product_);
    const double length = angle / product_.dot(shadow_);
    if (!std::isfinite(length)) return i > 0;
    step += length * preconditioned_;
    rest_ -= length * product_;
    precondition(rest_, second_);
    system.multiply(second_, second_product_);
    products_ += 2;
    const double norm2 = second_product_.squaredNorm();
    const double second_length = norm2 > 0.0 ? second_product_.dot(rest_) / norm2 : 0.0;
    step += second_length * second_;
    rest_ -= second_length * second_product_;
    if (!(rest_.cwiseProduct(scale).norm() > enough)) break;
    const double before = angle;
    angle = rest_.dot(shadow_);
    search_ =
        rest_ + angle / before * length / second_length * (search_ - second_length * product_);
  }
  return true;
}

}  // namespace stillgrid::dynamics
