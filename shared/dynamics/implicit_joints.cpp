#include "shared/dynamics/implicit_joints.hpp"

#include "shared/dynamics/joint_forces.hpp"

namespace stillgrid::dynamics {
namespace {

struct EndPlaces {
  Eigen::Vector3d before_m, after_m;
};

/// Sets the arm of the point, too.
EndPlaces places_of(const Description::JointEnd& end, const ImplicitPoses& poses,
                    ActedPoint& point) {
  if (end.node >= 0) {
    const auto node = static_cast<std::size_t>(end.node);
    return {poses.from().node_position_m[node].vector(), poses.to().node_position_m[node].vector()};
  }
  if (end.rigid < 0) return {end.point_m, end.point_m};
  const auto r = static_cast<std::size_t>(end.rigid);
  point.arm_m = poses.mean_arm_m(r, end.point_m);
  return {poses.from().rigid_position_m[r].vector() + poses.arm_before_m(r, end.point_m),
          poses.to().rigid_position_m[r].vector() + poses.arm_m(r, end.point_m)};
}

ActedPoint point_of(const Description::JointEnd& end) {
  ActedPoint point;
  if (end.node >= 0)
    point.set_node(end.node);
  else
    point.rigid = end.rigid;
  return point;
}

}  // namespace

std::vector<Coupling> joint_couplings(const Description& description) {
  std::vector<Coupling> couplings;
  for (const Description::Joint& joint : description.joints)
    if (joint.rest_length_m <= 0.0)
      couplings.push_back({.a = point_of(joint.a), .b = point_of(joint.b), .is_active = true});
  return couplings;
}

void leave_out_joints(std::span<const std::uint8_t> sleeping_nodes,
                      std::span<const std::uint8_t> sleeping_rigid_bodies,
                      std::vector<Coupling>& couplings) {
  const auto sleeps = [&](const ActedPoint& point) {
    return point.rigid >= 0 ? sleeping_rigid_bodies[static_cast<std::size_t>(point.rigid)] != 0
                            : point.node_count > 0 &&
                                  sleeping_nodes[static_cast<std::size_t>(point.nodes[0])] != 0;
  };
  for (Coupling& coupling : couplings)
    coupling.is_active = !sleeps(coupling.a) && !sleeps(coupling.b);
}

void evaluate_joints(const Description& description, const ImplicitPoses& poses,
                     const Motions& velocities, std::vector<Coupling>& couplings) {
  const double h = poses.step_s();
  auto next = couplings.begin();
  for (const Description::Joint& joint : description.joints) {
    if (joint.rest_length_m > 0.0) continue;
    const auto coupling = next++;
    if (!coupling->is_active) continue;
    const EndPlaces a = places_of(joint.a, poses, coupling->a);
    const EndPlaces b = places_of(joint.b, poses, coupling->b);
    Eigen::Matrix3d damping = joint.damping_N_s_per_m * Eigen::Matrix3d::Identity();
    if (joint.a.node >= 0 && joint.b.node >= 0) {
      const Eigen::Vector3d line = 0.5 * (a.before_m - b.before_m + a.after_m - b.after_m);
      damping = joint.damping_N_s_per_m / (line.squaredNorm() + kShortestLine_m2) * line *
                line.transpose();
    }
    coupling->impulse_N_s = -h * joint.stiffness_N_per_m * (a.after_m - b.after_m) -
                            h * damping * relative_velocity(*coupling, velocities, poses);
    coupling->slope_kg =
        h * h * joint.stiffness_N_per_m * Eigen::Matrix3d::Identity() + h * damping;
  }
}

double joint_damping_J(const Description& description, const ImplicitPoses& poses,
                       const Motions& velocities, const std::vector<Coupling>& couplings) {
  const double h = poses.step_s();
  double sum_J = 0.0;
  auto next = couplings.begin();
  for (const Description::Joint& joint : description.joints) {
    if (joint.rest_length_m > 0.0) continue;
    const auto coupling = next++;
    if (!coupling->is_active) continue;
    const Eigen::Vector3d velocity = relative_velocity(*coupling, velocities, poses);
    // The slope is that of the spring, h^2 k in all directions, and h times the damping.
    sum_J += velocity.dot(coupling->slope_kg * velocity) -
             h * h * joint.stiffness_N_per_m * velocity.squaredNorm();
  }
  return sum_J;
}

}  // namespace stillgrid::dynamics
