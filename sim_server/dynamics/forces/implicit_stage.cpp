#include "sim_server/dynamics/forces/implicit_stage.hpp"

namespace stillgrid::dynamics {

ImplicitStage::ImplicitStage(MechanicalSystem& system, double step_s)
    : system_(system), step_s_(step_s) {
  const Eigen::VectorXd velocity = system.velocity();
  system.place(Eigen::VectorXd::Zero(system.size()), velocity, 0.0);
  system.momentum(velocity, start_momentum_);
}

void ImplicitStage::residual(const Eigen::VectorXd& u, Eigen::VectorXd& residual) {
  displacement_ = step_s_ * u;
  system_.place(displacement_, u, step_s_);
  system_.momentum(u, residual);
  system_.force(step_s_, force_);
  residual -= start_momentum_ + step_s_ * force_;
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
