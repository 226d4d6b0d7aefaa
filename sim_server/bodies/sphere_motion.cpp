#include "sim_server/bodies/sphere_motion.hpp"

#include "sim_server/bodies/rotation.hpp"

namespace stillgrid {

SphereMotion sphere_motion(std::span<const Node> nodes, std::span<const RigidBody> rigid_bodies,
                           const SphereBinding& sphere) {
  SphereMotion motion;
  if (sphere.rigid >= 0) {
    const RigidBody& body = rigid_bodies[static_cast<std::size_t>(sphere.rigid)];
    const Eigen::Vector3d arm_m = body.orientation * sphere.local_m;
    motion.position_m = body.position_m + arm_m;
    motion.velocity_m_s = body.velocity_m_s + body.angular_velocity_rad_s.cross(arm_m);
    return motion;
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(sphere.node_count); ++i) {
    const Node& node = nodes[static_cast<std::size_t>(sphere.nodes[i])];
    motion.position_m += sphere.weights[i] * node.position_m;
    motion.velocity_m_s += sphere.weights[i] * node.velocity_m_s;
  }
  return motion;
}

SphereParts sphere_parts(std::span<const Node> nodes, std::span<const RigidBody> rigid_bodies,
                         const SphereBinding& sphere, double step_s) {
  SphereParts result;
  const auto add = [&](int unknown, bool is_rotation, const Eigen::Matrix3d& lever,
                       const Eigen::Matrix3d& position, const Eigen::Matrix3d& velocity) {
    result.parts[static_cast<std::size_t>(result.count++)] = {unknown, is_rotation, lever, position,
                                                              velocity};
  };
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  if (sphere.rigid >= 0) {
    const RigidBody& body = rigid_bodies[static_cast<std::size_t>(sphere.rigid)];
    if (body.unknown == kNoUnknown) return result;
    // An arm r turned by d theta = h J dw moves by -[r] d theta, and w x r with it.
    const Eigen::Matrix3d lever = -cross_matrix(body.orientation * sphere.local_m);
    const Eigen::Matrix3d arm_by_spin =
        step_s * lever * left_jacobian(step_s * body.angular_velocity_rad_s);
    add(body.unknown, false, identity, step_s * identity, identity);
    add(body.unknown + 3, true, lever, arm_by_spin,
        lever + cross_matrix(body.angular_velocity_rad_s) * arm_by_spin);
    return result;
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(sphere.node_count); ++i) {
    const int unknown = nodes[static_cast<std::size_t>(sphere.nodes[i])].unknown;
    if (unknown == kNoUnknown) continue;
    const Eigen::Matrix3d weight = sphere.weights[i] * identity;
    add(unknown, false, weight, step_s * weight, weight);
  }
  return result;
}

}  // namespace stillgrid
