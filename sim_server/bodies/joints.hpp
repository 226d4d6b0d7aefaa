#pragma once

#include <Eigen/Core>
#include <span>

#include "sim_server/bodies/world.hpp"

namespace stillgrid::bodies {

/// An end of a joint as it moves. World frame.
struct EndMotion {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();      // of mass; a node or a place itself
  Eigen::Vector3d arm_m = Eigen::Vector3d::Zero();         // from there to the end
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  // of the centre
  Eigen::Vector3d spin_rad_s = Eigen::Vector3d::Zero();
};
[[nodiscard]] EndMotion end_motion(const JointEnd& end, std::span<const Node> nodes,
                                   std::span<const RigidBody> rigid_bodies);

/// What a joint pulls its end a with; b with the opposite, both at the place of a: a spring's force
/// is along the line between them, and so neither makes a torque of the two.
struct JointPull {
  Eigen::Vector3d line_m;        // from b to a
  Eigen::Vector3d lever_b_m;     // from the centre of b to the place of a
  Eigen::Vector3d velocity_m_s;  // of a seen from b, both there
  Eigen::Vector3d spring_N, damper_N;
};
[[nodiscard]] JointPull joint_pull(const Joint& joint, const EndMotion& a, const EndMotion& b);

/// Between nodes a damper acts along their line alone, for a node takes up no torque: damper_N is
/// the velocity times this matrix. Elsewhere it is that of any direction. N s/m.
[[nodiscard]] Eigen::Matrix3d joint_damping_N_s_per_m(const Joint& joint,
                                                      const Eigen::Vector3d& line_m);
/// Square of the length from which on a line has a direction.
inline constexpr double kShortestLine_m2 = 1e-10;

/// Of what stretches it.
[[nodiscard]] double joint_energy_J(const Joint& joint, std::span<const Node> nodes,
                                    std::span<const RigidBody> rigid_bodies);

}  // namespace stillgrid::bodies
