// What joints add to a mechanical system's forces and to how they change.

#include "sim_server/bodies/rotation.hpp"
#include "sim_server/dynamics/forces/mechanical_system.hpp"

namespace stillgrid::dynamics {

/// Those with an end that moves.
void MechanicalSystem::take_joints() {
  joints_.clear();
  const auto moves = [&](const bodies::JointEnd& end) {
    if (end.node >= 0)
      return world_->nodes[static_cast<std::size_t>(end.node)].unknown != bodies::kNoUnknown;
    return end.rigid >= 0 &&
           world_->rigid_bodies[static_cast<std::size_t>(end.rigid)].unknown != bodies::kNoUnknown;
  };
  for (const bodies::Joint& joint : world_->joints)
    if (moves(joint.a) || moves(joint.b)) joints_.push_back(&joint);
}

/// An end where all was placed last.
JointSide MechanicalSystem::joint_side(const bodies::JointEnd& end) const {
  JointSide side{.motion = bodies::end_motion(end, trial_.nodes, trial_.rigid_bodies)};
  side.mean_arm_m = side.motion.arm_m;
  if (end.node >= 0) side.velocity = trial_.nodes[static_cast<std::size_t>(end.node)].unknown;
  if (end.rigid < 0) return side;
  const auto rigid = static_cast<std::size_t>(end.rigid);
  side.velocity = trial_.rigid_bodies[rigid].unknown;
  if (side.velocity == bodies::kNoUnknown) return side;
  side.spin = side.velocity + 3;
  if (levers_ == Levers::kMean) side.mean_arm_m += mean_turns_[rigid] * side.motion.arm_m;
  return side;
}

void MechanicalSystem::add_joint_forces(Eigen::VectorXd& force) const {
  for (const bodies::Joint* joint : joints_) {
    const JointSide a = joint_side(joint->a), b = joint_side(joint->b);
    const JointForce pull = joint_force(*joint, a, b);
    const std::array unknowns = {a.velocity, a.spin, b.velocity, b.spin};
    for (std::size_t k = 0; k < unknowns.size(); ++k)
      if (unknowns[k] != bodies::kNoUnknown)
        force.segment<3>(unknowns[k]) += pull.segment<3>(3 * static_cast<Eigen::Index>(k));
  }
}

/// After those of inertia, which know how bodies turn.
void MechanicalSystem::add_joint_jacobians(JacobianKind kind) {
  joint_jacobians_.clear();
  const auto side = [&](const bodies::JointEnd& end) {
    JointSide own = joint_side(end);
    if (own.spin == bodies::kNoUnknown) return own;
    const auto rigid = static_cast<std::size_t>(end.rigid);
    own.turn_s = turn_s_[rigid];
    own.mean_arm_by_spin_m_s = -bodies::cross_matrix(own.motion.arm_m) * own.turn_s;
    if (levers_ == Levers::kMean)
      own.mean_arm_by_spin_m_s =
          stage_s_ * bodies::mean_arm_by_turn(
                         turned_rad_[rigid], world_->rigid_bodies[rigid].orientation * end.point_m);
    return own;
  };
  for (const bodies::Joint* joint : joints_)
    joint_jacobians_.push_back(
        joint_jacobian(*joint, side(joint->a), side(joint->b), kind, stage_s_));
}

}  // namespace stillgrid::dynamics
