#include "shared/dynamics/joint_forces.hpp"

namespace stillgrid::dynamics {
namespace {

struct EndMotion {
  Eigen::Vector3d centre_m, arm_m, velocity_m_s, spin_rad_s;
};

EndMotion motion_of(const Description::JointEnd& end, const SceneState& state) {
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  if (end.node >= 0) {
    const auto node = static_cast<std::size_t>(end.node);
    return {state.node_position_m[node].vector(), zero, state.node_velocity_m_s[node].vector(),
            zero};
  }
  if (end.rigid < 0) return {end.point_m, zero, zero, zero};
  const auto r = static_cast<std::size_t>(end.rigid);
  return {state.rigid_position_m[r].vector(), state.orientation[r].quaternion() * end.point_m,
          state.rigid_velocity_m_s[r].vector(), state.angular_velocity_rad_s[r].vector()};
}

}  // namespace

void add_joint_forces(std::span<const Description::Joint> joints, const SceneState& state,
                      std::span<Vector4> node_forces_N, std::span<Wrench> rigid_wrenches) {
  for (const Description::Joint& joint : joints) {
    const EndMotion a = motion_of(joint.a, state), b = motion_of(joint.b, state);
    const Eigen::Vector3d arm_b = a.centre_m + a.arm_m - b.centre_m, line = arm_b - b.arm_m;
    const Eigen::Vector3d velocity =
        a.velocity_m_s + a.spin_rad_s.cross(a.arm_m) - b.velocity_m_s - b.spin_rad_s.cross(arm_b);
    Eigen::Vector3d stretch = line, damped = velocity;
    if (joint.rest_length_m > 0.0) stretch -= joint.rest_length_m * line.stableNormalized();
    if (joint.a.node >= 0 && joint.b.node >= 0)
      damped = line.dot(velocity) / (line.squaredNorm() + kShortestLine_m2) * line;
    const Eigen::Vector3d force =
        -joint.stiffness_N_per_m * stretch - joint.damping_N_s_per_m * damped;
    const auto push = [&](const Description::JointEnd& end, const Eigen::Vector3d& arm,
                          const Eigen::Vector3d& on_end) {
      if (end.node >= 0) {
        Vector4& sum = node_forces_N[static_cast<std::size_t>(end.node)];
        sum = sum + Vector4(on_end);
      } else if (end.rigid >= 0) {
        Wrench& sum = rigid_wrenches[static_cast<std::size_t>(end.rigid)];
        sum.force_N += on_end;
        sum.torque_N_m += arm.cross(on_end);
      }
    };
    push(joint.a, a.arm_m, force);
    push(joint.b, arm_b, -force);
  }
}

}  // namespace stillgrid::dynamics
