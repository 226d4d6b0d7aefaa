#include "sim_server/dynamics/integrators/implicit_stage.hpp"

#include <utility>

namespace stillgrid::dynamics {

StageRule implicit_euler_rule(MechanicalSystem& system, double end_s) {
  StageRule rule{.momentum = {}, .stage_s = end_s, .end_s = end_s};
  const Eigen::VectorXd velocity = system.velocity();
  system.place(Eigen::VectorXd::Zero(system.size()), velocity, 0.0, 0.0);
  system.momentum(velocity, rule.momentum);
  return rule;
}

ImplicitStage::ImplicitStage(MechanicalSystem& system, StageRule rule)
    : system_(system), rule_(std::move(rule)) {}

ImplicitStage::ImplicitStage(MechanicalSystem& system, double step_s)
    : ImplicitStage(system, implicit_euler_rule(system, step_s)) {}

void ImplicitStage::residual(const Eigen::VectorXd& u, Eigen::VectorXd& residual) {
  displacement_ = rule_.stage_s * u;
  system_.place(displacement_, u, rule_.end_s);
  system_.momentum(u, residual);
  system_.force(rule_.stage_s, force_);
  residual -= rule_.momentum + rule_.stage_s * force_;
}

void ImplicitStage::multiply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
  system_.multiply(x, y);
}

const Eigen::Matrix3Xd& ImplicitStage::block_diagonal() const {
  return system_.block_diagonal();
}

const Eigen::VectorXd& ImplicitStage::mass_diagonal() const {
  return system_.mass_diagonal();
}

const Eigen::VectorXd& ImplicitStage::residual_scale() const {
  return system_.momentum_scale();
}

}  // namespace stillgrid::dynamics
