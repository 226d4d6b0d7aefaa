#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "sim_server/bodies/joints.hpp"
#include "sim_server/dynamics/forces/contact_jacobian.hpp"
#include "sim_server/dynamics/solvers/nonlinear_solver.hpp"

namespace stillgrid::dynamics {

/// An end of a joint over an implicit stage. Of what has no unknowns the last two are not read.
struct JointSide {
  bodies::EndMotion motion;
  int velocity = bodies::kNoUnknown, spin = bodies::kNoUnknown;  // first unknowns
  Eigen::Vector3d mean_arm_m = Eigen::Vector3d::Zero();          // by which the spring presses
  Eigen::Matrix3d turn_s = Eigen::Matrix3d::Zero();  // d(its turning, world frame) / d spin
  Eigen::Matrix3d mean_arm_by_spin_m_s = Eigen::Matrix3d::Zero();
};

/// Forces and torques of a joint on its ends: of a the force, the torque, and of b.
using JointForce = Eigen::Matrix<double, 12, 1>;
[[nodiscard]] JointForce joint_force(const bodies::Joint& joint, const JointSide& a,
                                     const JointSide& b);

/// d(momentum - stage_s force) / du of a joint, by its ends' unknowns in the same order.
struct JointJacobian {
  std::array<int, 4> unknowns{};  // first of each three; or kNoUnknown
  Eigen::Matrix<double, 12, 12> change;
};
[[nodiscard]] JointJacobian joint_jacobian(const bodies::Joint& joint, const JointSide& a,
                                           const JointSide& b, JacobianKind kind, double stage_s);

/// y += Jacobian x.
void multiply_add(const JointJacobian& jacobian, const Eigen::VectorXd& x, Eigen::VectorXd& y);

/// Adds its blocks on the diagonal to those of all unknowns, side by side.
void add_diagonal(const JointJacobian& jacobian, Eigen::Matrix3Xd& blocks);

}  // namespace stillgrid::dynamics
