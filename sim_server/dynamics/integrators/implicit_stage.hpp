#pragma once

#include <Eigen/Core>

#include "sim_server/dynamics/forces/mechanical_system.hpp"
#include "sim_server/dynamics/solvers/nonlinear_solver.hpp"

namespace stillgrid::dynamics {

/// A step of implicit Euler, or of a method that solves the same equations: p* (a momentum), s and
/// the end of the stage.
struct StageRule {
  Eigen::VectorXd momentum;
  double stage_s = 0.0;
  double end_s = 0.0;  // from the world's time to the stage's
};

/// Implicit Euler's over end_s: p* is the world's momentum, s = end_s. Leaves the system at the
/// world's own state.
[[nodiscard]] StageRule implicit_euler_rule(MechanicalSystem& system, double end_s);

/// One stage of an implicit method, in the velocities u at its end:
///   r(u) = M(q1) u - p* - s f(t1, q1, u) = 0,   q1 = s u from the world's configuration.
/// For rotations the balance is that of angular momentum itself: the gyroscopic term is in it.
/// Contacts' dampers act over s.
class ImplicitStage : public NonlinearSystem {
 public:
  /// Pre: the system outlives it. rule.stage_s > 0.
  ImplicitStage(MechanicalSystem& system, StageRule rule);
  /// Implicit Euler's. Pre: step_s > 0.
  ImplicitStage(MechanicalSystem& system, double step_s);

  [[nodiscard]] Eigen::Index size() const override { return system_.size(); }
  void residual(const Eigen::VectorXd& u, Eigen::VectorXd& residual) override;
  void linearise(JacobianKind kind) override { system_.linearise(kind, rule_.stage_s); }
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

  /// s u, where the last residual() was.
  [[nodiscard]] const Eigen::VectorXd& displacement() const { return displacement_; }

 private:
  MechanicalSystem& system_;
  StageRule rule_;
  Eigen::VectorXd displacement_, force_;
};

}  // namespace stillgrid::dynamics
