#include "sim_server/bodies/joints.hpp"

namespace stillgrid::bodies {
namespace {

/// World frame.
Eigen::Vector3d place_m(const JointEnd& end, std::span<const Node> nodes,
                        std::span<const RigidBody> rigid_bodies) {
  if (end.node >= 0) return nodes[static_cast<std::size_t>(end.node)].position_m;
  if (end.rigid < 0) return end.point_m;
  const RigidBody& body = rigid_bodies[static_cast<std::size_t>(end.rigid)];
  return body.position_m + body.orientation * end.point_m;
}

}  // namespace

double joint_energy_J(const Joint& joint, std::span<const Node> nodes,
                      std::span<const RigidBody> rigid_bodies) {
  Eigen::Vector3d stretch_m =
      place_m(joint.a, nodes, rigid_bodies) - place_m(joint.b, nodes, rigid_bodies);
  if (joint.rest_length_m != 0.0) stretch_m -= joint.rest_length_m * stretch_m.stableNormalized();
  return 0.5 * joint.stiffness_N_per_m * stretch_m.squaredNorm();
}

}  // namespace stillgrid::bodies
