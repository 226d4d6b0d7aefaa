#include "sim_server/bodies/joints.hpp"

namespace stillgrid::bodies {
namespace {

/// By how much a joint is longer than at rest, from b to a.
Eigen::Vector3d stretch_m(const Joint& joint, const Eigen::Vector3d& line_m) {
  if (joint.rest_length_m == 0.0) return line_m;
  return line_m - joint.rest_length_m * line_m.stableNormalized();
}

}  // namespace

EndMotion end_motion(const JointEnd& end, std::span<const Node> nodes,
                     std::span<const RigidBody> rigid_bodies) {
  if (end.node >= 0) {
    const Node& node = nodes[static_cast<std::size_t>(end.node)];
    return {.centre_m = node.position_m, .velocity_m_s = node.velocity_m_s};
  }
  if (end.rigid < 0) return {.centre_m = end.point_m};
  const RigidBody& body = rigid_bodies[static_cast<std::size_t>(end.rigid)];
  return {body.position_m, body.orientation * end.point_m, body.velocity_m_s,
          body.angular_velocity_rad_s};
}

Eigen::Matrix3d joint_damping_N_s_per_m(const Joint& joint, const Eigen::Vector3d& line_m) {
  if (joint.b.node < 0) return joint.damping_N_s_per_m * Eigen::Matrix3d::Identity();
  return joint.damping_N_s_per_m / (line_m.squaredNorm() + kShortestLine_m2) * line_m *
         line_m.transpose();
}

JointPull joint_pull(const Joint& joint, const EndMotion& a, const EndMotion& b) {
  JointPull pull;
  pull.lever_b_m = a.centre_m + a.arm_m - b.centre_m;
  pull.line_m = pull.lever_b_m - b.arm_m;
  pull.velocity_m_s = a.velocity_m_s + a.spin_rad_s.cross(a.arm_m) - b.velocity_m_s -
                      b.spin_rad_s.cross(pull.lever_b_m);
  pull.spring_N = -joint.stiffness_N_per_m * stretch_m(joint, pull.line_m);
  pull.damper_N = -joint_damping_N_s_per_m(joint, pull.line_m) * pull.velocity_m_s;
  return pull;
}

double joint_energy_J(const Joint& joint, std::span<const Node> nodes,
                      std::span<const RigidBody> rigid_bodies) {
  const EndMotion a = end_motion(joint.a, nodes, rigid_bodies);
  const EndMotion b = end_motion(joint.b, nodes, rigid_bodies);
  const Eigen::Vector3d line_m = a.centre_m + a.arm_m - b.centre_m - b.arm_m;
  return 0.5 * joint.stiffness_N_per_m * stretch_m(joint, line_m).squaredNorm();
}

}  // namespace stillgrid::bodies
