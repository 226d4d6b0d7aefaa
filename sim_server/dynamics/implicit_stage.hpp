#pragma once

#include <Eigen/Core>

#include "sim_server/dynamics/mechanical_system.hpp"
#include "sim_server/dynamics/nonlinear_solver.hpp"

namespace stillgrid {

/// One stage of an implicit method, in the velocities u at its end:
///   r(u) = M(q1) u - p* - s f(t1, q1, u) = 0,   q1 = q* + s u,
/// where q* (a displacement from the world's configuration), p* (a momentum) and s come from the
/// method: implicit Euler has q* = 0, p* = M u0, s = h. For rotations the balance is that of
/// angular momentum itself: the gyroscopic term is in it.
class ImplicitStage : public NonlinearSystem {
 public:
  /// Implicit Euler's stage. Pre: the system outlives it. stage_s > 0.
  ImplicitStage(MechanicalSystem& system, double stage_s);

  [[nodiscard]] Eigen::Index size() const override { return system_.size(); }
  void residual(const Eigen::VectorXd& u, Eigen::VectorXd& residual) override;
  void jacobian(Slope slope, Eigen::SparseMatrix<double>& matrix) override;
  void linearise(Slope slope) override { system_.linearise(slope, stage_s_); }
  void multiply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const override;
  [[nodiscard]] const Eigen::Matrix3Xd& block_diagonal() const override;
  [[nodiscard]] const Eigen::VectorXd& mass_diagonal() const override;
  [[nodiscard]] const Eigen::VectorXd& residual_scale() const override;

  /// The velocities at the step's start: a first guess.
  [[nodiscard]] Eigen::VectorXd initial_guess() const { return system_.velocity(); }

 private:
  MechanicalSystem& system_;
  double stage_s_;
  Eigen::VectorXd base_displacement_, base_momentum_;
  Eigen::VectorXd displacement_, force_;
};

}  // namespace stillgrid
