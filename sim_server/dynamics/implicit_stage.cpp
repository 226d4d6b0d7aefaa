#include "sim_server/dynamics/implicit_stage.hpp"

namespace stillgrid {

ImplicitStage::ImplicitStage(MechanicalSystem& system, double stage_s)
    : system_(system), stage_s_(stage_s), base_displacement_(Eigen::VectorXd::Zero(system.size())) {
  system_.place(base_displacement_, system_.velocity(), 0.0);
  system_.momentum(base_momentum_);
}

void ImplicitStage::residual(const Eigen::VectorXd& u, Eigen::VectorXd& residual) {
  displacement_ = base_displacement_ + stage_s_ * u;
  system_.place(displacement_, u, stage_s_);
  system_.momentum(residual);
  system_.force(stage_s_, force_);
  residual -= base_momentum_ + stage_s_ * force_;
}

void ImplicitStage::jacobian(Slope slope, Eigen::SparseMatrix<double>& matrix) {
  system_.jacobian(slope, stage_s_, matrix);
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

}  // namespace stillgrid
