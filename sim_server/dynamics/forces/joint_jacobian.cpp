#include "sim_server/dynamics/forces/joint_jacobian.hpp"

#include <algorithm>

#include "sim_server/bodies/rotation.hpp"

namespace stillgrid::dynamics {
namespace {

using bodies::cross_matrix;
using bodies::JointPull;
/// How a vector changes with the velocity and the spin of a, and of b.
using Change = Eigen::Matrix<double, 3, 12>;

/// How the spring's force changes with the line, less its sign.
Eigen::Matrix3d stiffness_N_per_m(const bodies::Joint& joint, const Eigen::Vector3d& line_m,
                                  bool is_definite) {
  Eigen::Matrix3d stiffness = joint.stiffness_N_per_m * Eigen::Matrix3d::Identity();
  const double length_m = line_m.norm();
  if (joint.rest_length_m == 0.0 || length_m == 0.0) return stiffness;
  const Eigen::Vector3d n = line_m / length_m;
  double slack = joint.rest_length_m / length_m;
  if (is_definite) slack = std::min(slack, 1.0);
  return stiffness -
         slack * joint.stiffness_N_per_m * (Eigen::Matrix3d::Identity() - n * n.transpose());
}

/// How the damper's force changes as the line does, less its sign.
Eigen::Matrix3d damping_by_line_N_per_m(const bodies::Joint& joint, const JointPull& pull) {
  if (joint.b.node < 0) return Eigen::Matrix3d::Zero();
  const Eigen::Vector3d &d = pull.line_m, &v = pull.velocity_m_s;
  const double square_m2 = d.squaredNorm() + bodies::kShortestLine_m2;
  const double rate_m2_s = d.dot(v);
  return joint.damping_N_s_per_m / square_m2 *
         (rate_m2_s * Eigen::Matrix3d::Identity() + d * v.transpose() -
          2.0 * rate_m2_s / square_m2 * d * d.transpose());
}

/// What holds an arm that a force pulls at: how its torque changes as it turns, less its sign, made
/// symmetric; definite: of what pulls outwards alone.
Eigen::Matrix3d turning_moment_N_m(const Eigen::Vector3d& force_N, const Eigen::Vector3d& arm_m,
                                   bool is_definite) {
  const double moment_N_m = force_N.dot(arm_m);
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  if (!is_definite)
    return moment_N_m * one - 0.5 * (force_N * arm_m.transpose() + arm_m * force_N.transpose());
  if (!(moment_N_m > 0.0)) return Eigen::Matrix3d::Zero();
  return moment_N_m * (one - arm_m * arm_m.transpose() / arm_m.squaredNorm());
}

Eigen::Matrix<double, 12, 12> symmetric_change(const bodies::Joint& joint, const JointSide& a,
                                               const JointSide& b, const JointPull& pull,
                                               bool is_definite, double stage_s) {
  Change moved;
  moved << Eigen::Matrix3d::Identity(), -cross_matrix(a.motion.arm_m), -Eigen::Matrix3d::Identity(),
      cross_matrix(pull.lever_b_m);
  const Eigen::Matrix3d resists =
      stage_s * (stage_s * stiffness_N_per_m(joint, pull.line_m, is_definite) +
                 bodies::joint_damping_N_s_per_m(joint, pull.line_m));
  Eigen::Matrix<double, 12, 12> change = moved.transpose() * resists * moved;
  const double square_s2 = stage_s * stage_s;
  change.block<3, 3>(3, 3) +=
      square_s2 * turning_moment_N_m(pull.spring_N, a.motion.arm_m, is_definite);
  change.block<3, 3>(9, 9) +=
      square_s2 * turning_moment_N_m(-pull.spring_N, b.motion.arm_m, is_definite);
  return change;
}

Eigen::Matrix<double, 12, 12> exact_change(const bodies::Joint& joint, const JointSide& a,
                                           const JointSide& b, const JointPull& pull,
                                           double stage_s) {
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  const Eigen::Vector3d &arm_a = a.motion.arm_m, &arm_b = b.motion.arm_m;
  Change turned_a = Change::Zero(), turned_b = Change::Zero();  // the arms
  turned_a.middleCols<3>(3) = -cross_matrix(arm_a) * a.turn_s;
  turned_b.middleCols<3>(9) = -cross_matrix(arm_b) * b.turn_s;
  Change lever = turned_a;  // from the centre of b to the place of a
  lever.middleCols<3>(0) += stage_s * one;
  lever.middleCols<3>(6) -= stage_s * one;
  Change velocity =
      cross_matrix(a.motion.spin_rad_s) * turned_a - cross_matrix(b.motion.spin_rad_s) * lever;
  velocity.middleCols<3>(0) += one;
  velocity.middleCols<3>(3) -= cross_matrix(arm_a);
  velocity.middleCols<3>(6) -= one;
  velocity.middleCols<3>(9) += cross_matrix(pull.lever_b_m);
  const Change line = lever - turned_b;
  const Change spring = -stiffness_N_per_m(joint, pull.line_m, false) * line;
  const Change damper = -bodies::joint_damping_N_s_per_m(joint, pull.line_m) * velocity -
                        damping_by_line_N_per_m(joint, pull) * line;
  Change mean_a = Change::Zero(), mean_b = Change::Zero();
  mean_a.middleCols<3>(3) = a.mean_arm_by_spin_m_s;
  mean_b.middleCols<3>(9) = b.mean_arm_by_spin_m_s;
  const Eigen::Matrix3d spring_cross = cross_matrix(pull.spring_N);
  const Eigen::Matrix3d damper_cross = cross_matrix(pull.damper_N);
  Eigen::Matrix<double, 12, 12> force;
  force.middleRows<3>(0) = spring + damper;
  force.middleRows<3>(3) = cross_matrix(a.mean_arm_m) * spring - spring_cross * mean_a +
                           cross_matrix(arm_a) * damper - damper_cross * turned_a;
  force.middleRows<3>(6) = -(spring + damper);
  force.middleRows<3>(9) = spring_cross * mean_b - cross_matrix(b.mean_arm_m) * spring +
                           damper_cross * lever - cross_matrix(pull.lever_b_m) * damper;
  return -stage_s * force;
}

}  // namespace

JointForce joint_force(const bodies::Joint& joint, const JointSide& a, const JointSide& b) {
  const JointPull pull = bodies::joint_pull(joint, a.motion, b.motion);
  const Eigen::Vector3d force_N = pull.spring_N + pull.damper_N;
  JointForce force;
  force << force_N, a.mean_arm_m.cross(pull.spring_N) + a.motion.arm_m.cross(pull.damper_N),
      -force_N, -b.mean_arm_m.cross(pull.spring_N) - pull.lever_b_m.cross(pull.damper_N);
  return force;
}

JointJacobian joint_jacobian(const bodies::Joint& joint, const JointSide& a, const JointSide& b,
                             JacobianKind kind, double stage_s) {
  const JointPull pull = bodies::joint_pull(joint, a.motion, b.motion);
  return {{a.velocity, a.spin, b.velocity, b.spin},
          kind == JacobianKind::kExact
              ? exact_change(joint, a, b, pull, stage_s)
              : symmetric_change(joint, a, b, pull, kind == JacobianKind::kDefinite, stage_s)};
}

void multiply_add(const JointJacobian& jacobian, const Eigen::VectorXd& x, Eigen::VectorXd& y) {
  JointForce change = JointForce::Zero();
  for (Eigen::Index k = 0; k < 4; ++k)
    if (const int unknown = jacobian.unknowns[static_cast<std::size_t>(k)];
        unknown != bodies::kNoUnknown)
      change += jacobian.change.middleCols<3>(3 * k) * x.segment<3>(unknown);
  for (Eigen::Index k = 0; k < 4; ++k)
    if (const int unknown = jacobian.unknowns[static_cast<std::size_t>(k)];
        unknown != bodies::kNoUnknown)
      y.segment<3>(unknown) += change.segment<3>(3 * k);
}

void add_diagonal(const JointJacobian& jacobian, Eigen::Matrix3Xd& blocks) {
  for (Eigen::Index i = 0; i < 4; ++i) {
    const int row = jacobian.unknowns[static_cast<std::size_t>(i)];
    if (row != bodies::kNoUnknown)
      blocks.middleCols<3>(row) += jacobian.change.block<3, 3>(3 * i, 3 * i);
  }
}

}  // namespace stillgrid::dynamics
