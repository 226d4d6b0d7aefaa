#pragma once

#include <Eigen/Core>

#include "sim_server/dynamics/solvers/nonlinear_solver.hpp"

namespace stillgrid::dynamics {

/// A u + strength u^3 = 1 with a chain for A: smooth, with one solution.
class CubicChain : public NonlinearSystem {
 public:
  static constexpr Eigen::Index kSize = 9;

  explicit CubicChain(double strength) : strength_(strength) {}
  [[nodiscard]] Eigen::Index size() const override { return kSize; }
  void residual(const Eigen::VectorXd& u, Eigen::VectorXd& residual) override {
    at_ = u;
    residual = derivative(0.0) * u + strength_ * u.array().cube().matrix() - ones_;
  }
  void linearise(JacobianKind) override {
    matrix_ = derivative(strength_);
    for (Eigen::Index i = 0; i < kSize; i += 3)
      diagonal_.middleCols<3>(i) = matrix_.block<3, 3>(i, i);
    triangle_.set_pattern(kSize / 3, {});
    for (int i = 0; i < kSize / 3; ++i) triangle_.diagonal(i) = diagonal_.middleCols<3>(3 * i);
  }
  [[nodiscard]] BlockTriangle& triangle() override { return triangle_; }
  void add_rest(const Eigen::VectorXd& x, Eigen::VectorXd& y) const override {
    y += matrix_ * x;
    for (Eigen::Index i = 0; i < kSize; i += 3)
      y.segment<3>(i) -= diagonal_.middleCols<3>(i) * x.segment<3>(i);
  }
  [[nodiscard]] bool has_rest() const override { return true; }
  void multiply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const override { y = matrix_ * x; }
  [[nodiscard]] const Eigen::Matrix3Xd& block_diagonal() const override { return diagonal_; }
  [[nodiscard]] const Eigen::VectorXd& mass_diagonal() const override { return ones_; }
  [[nodiscard]] const Eigen::VectorXd& residual_scale() const override { return ones_; }

 private:
  [[nodiscard]] Eigen::MatrixXd derivative(double strength) const {
    Eigen::MatrixXd derivative = 2.0 * Eigen::MatrixXd::Identity(kSize, kSize);
    derivative.diagonal(1).setConstant(-1.0);
    derivative.diagonal(-1).setConstant(-1.0);
    if (strength != 0.0) derivative.diagonal() += 3.0 * strength * at_.cwiseAbs2();
    return derivative;
  }

  double strength_;
  Eigen::VectorXd at_ = Eigen::VectorXd::Zero(kSize);
  Eigen::VectorXd ones_ = Eigen::VectorXd::Ones(kSize);
  Eigen::MatrixXd matrix_;
  BlockTriangle triangle_;
  Eigen::Matrix3Xd diagonal_ = Eigen::Matrix3Xd::Zero(3, kSize);
};

}  // namespace stillgrid::dynamics
