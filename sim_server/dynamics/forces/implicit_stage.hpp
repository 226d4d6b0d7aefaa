#pragma once

#include <Eigen/Core>

#include "sim_server/dynamics/forces/mechanical_system.hpp"
#include "sim_server/dynamics/solvers/nonlinear_solver.hpp"

namespace stillgrid::dynamics {

/// A step of implicit Euler over h, in the velocities u at its end:
///   r(u) = M(q1) u - p0 - h f(t1, q1, u) = 0,   q1 = h u from the world's configuration,
/// p0 the world's momentum.
/// For rotations the balance is that of angular momentum itself: the gyroscopic term is in it.
/// Contacts' dampers act over h.
class ImplicitStage : public NonlinearSystem {
 public:
  /// Leaves the system at the world's own state. Pre: the system outlives it. step_s > 0.
  ImplicitStage(MechanicalSystem& system, double step_s);

  [[nodiscard]] Eigen::Index size() const override { return system_.size(); }
  void residual(const Eigen::VectorXd& u, Eigen::VectorXd& residual) override;
  void linearise(JacobianKind kind) override { system_.linearise(kind, step_s_); }
  void multiply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const override;
  [[nodiscard]] const Eigen::Matrix3Xd& block_diagonal() const override;
  [[nodiscard]] BlockTriangle& triangle() override { return system_.triangle(); }
  void add_rest(const Eigen::VectorXd& x, Eigen::VectorXd& y) const override {
    system_.add_rest(x, y);
  }
  [[nodiscard]] bool has_rest() const override { return system_.has_rest(); }
  [[nodiscard]] const Eigen::VectorXd& mass_diagonal() const override;
  [[nodiscard]] const Eigen::VectorXd& residual_scale() const override;

  /// The velocities at the step's start: a first guess.
  [[nodiscard]] Eigen::VectorXd initial_guess() const { return system_.velocity(); }

  /// h u, where the last residual() was.
  [[nodiscard]] const Eigen::VectorXd& displacement() const { return displacement_; }

 private:
  MechanicalSystem& system_;
  double step_s_;
  Eigen::VectorXd start_momentum_, displacement_, force_;
};

}  // namespace stillgrid::dynamics
