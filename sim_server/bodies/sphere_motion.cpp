#include "sim_server/bodies/sphere_motion.hpp"

namespace stillgrid::bodies {

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

SphereMotion SphereMotions::operator()(const SphereBinding& sphere) {
  if (sphere.rigid < 0) return sphere_motion(nodes_, rigid_bodies_, sphere);
  const RigidBody& body = rigid_bodies_[static_cast<std::size_t>(sphere.rigid)];
  if (sphere.rigid != rigid_) {
    rigid_ = sphere.rigid;
    rotation_ = body.orientation.toRotationMatrix();
  }
  const Eigen::Vector3d arm_m = rotation_ * sphere.local_m;
  return {body.position_m + arm_m, body.velocity_m_s + body.angular_velocity_rad_s.cross(arm_m)};
}

}  // namespace stillgrid::bodies
