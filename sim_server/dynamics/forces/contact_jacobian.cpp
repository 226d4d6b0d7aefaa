#include "sim_server/dynamics/forces/contact_jacobian.hpp"

#include "sim_server/bodies/rotation.hpp"

namespace stillgrid::dynamics {
namespace {

using Response = Eigen::Matrix<double, 6, 3>;  // of force and couple

/// Relative motion of a contact.
struct Change {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();
};

void add_change(const ContactSide& side, double stage_s, bool is_exact, const Eigen::VectorXd& x,
                Change& change) {
  if (side.body == bodies::kNoUnknown) {
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < static_cast<std::size_t>(side.node_count); ++i)
      velocity += side.weights[i] * x.segment<3>(side.unknowns[i]);
    change.velocity += side.sign * velocity;
    if (is_exact) change.position += side.sign * stage_s * velocity;
    return;
  }
  const Eigen::Vector3d linear = x.segment<3>(side.body), spin = x.segment<3>(side.body + 3);
  change.velocity += side.sign * (linear + spin.cross(side.arm_m));
  change.spin += side.share * spin;
  if (!is_exact) return;
  // The arm turns, and carries the sphere with the spin that it has.
  const Eigen::Vector3d arm_moves = (side.turn_s * spin).cross(side.arm_m);
  change.position += side.sign * (stage_s * linear + arm_moves);
  change.velocity += side.sign * side.spin_rad_s.cross(arm_moves);
}

void push(const ContactSide& side, const Eigen::Vector3d& force, const Eigen::Vector3d& couple,
          Eigen::VectorXd& y) {
  if (side.body != bodies::kNoUnknown) {
    y.segment<3>(side.body) += side.sign * force;
    y.segment<3>(side.body + 3) += side.sign * side.arm_m.cross(force) + side.share * couple;
    return;
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(side.node_count); ++i)
    y.segment<3>(side.unknowns[i]) += side.sign * side.weights[i] * force;
}

/// d(r x F) = dr x F: the lever itself turns with the body.
Eigen::Vector3d lever_turns(const ContactSide& side, const ContactJacobian& jacobian,
                            const Eigen::Vector3d& spin) {
  return side.sign * ((side.turn_s * spin).cross(side.arm_m).cross(jacobian.friction_N) +
                      (side.press_arm_by_spin_m_s * spin).cross(jacobian.press_N));
}

/// What moving a side does: by its place or its nodes' and, if it is a body, by its spin.
struct SideResponse {
  Response linear, spin;
  // Of what presses alone, where the Jacobian is exact.
  Eigen::Matrix3d press_linear = Eigen::Matrix3d::Zero(), press_spin = Eigen::Matrix3d::Zero();
};

SideResponse response_of(const ContactJacobian& jacobian, const ContactSide& side, double stage_s) {
  SideResponse response;
  response.linear = side.sign * jacobian.by_motion.leftCols<3>();
  if (jacobian.is_exact) {
    response.linear += side.sign * stage_s * jacobian.by_position;
    response.press_linear = side.sign * stage_s * jacobian.press_by_position;
  }
  if (side.body == bodies::kNoUnknown) return response;
  const Eigen::Matrix3d lever = -bodies::cross_matrix(side.arm_m);
  Eigen::Matrix3d velocity = lever;
  if (jacobian.is_exact) velocity += bodies::cross_matrix(side.spin_rad_s) * lever * side.turn_s;
  response.spin = side.sign * jacobian.by_motion.leftCols<3>() * velocity +
                  side.share * jacobian.by_motion.rightCols<3>();
  if (jacobian.is_exact) {
    response.spin += side.sign * jacobian.by_position * lever * side.turn_s;
    response.press_spin = side.sign * jacobian.press_by_position * lever * side.turn_s;
  }
  return response;
}

Eigen::Matrix3d torque_of(const ContactSide& side, const Response& response,
                          const Eigen::Matrix3d& press) {
  return side.sign * (bodies::cross_matrix(side.arm_m) * response.topRows<3>() +
                      bodies::cross_matrix(side.press_arm_m) * press) +
         side.share * response.bottomRows<3>();
}

/// Adds the block of a response in the row of the unknown that moves, if it is one of this side.
void add_diagonal(const ContactSide& pushed, const Response& response, const Eigen::Matrix3d& press,
                  double factor, int row, Eigen::Matrix3Xd& blocks) {
  if (pushed.body != bodies::kNoUnknown) {
    if (row == pushed.body)
      blocks.middleCols<3>(row) += factor * pushed.sign * response.topRows<3>();
    if (row == pushed.body + 3)
      blocks.middleCols<3>(row) += factor * torque_of(pushed, response, press);
    return;
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(pushed.node_count); ++i)
    if (row == pushed.unknowns[i])
      blocks.middleCols<3>(row) += factor * pushed.sign * pushed.weights[i] * response.topRows<3>();
}

}  // namespace

ContactSide contact_side(std::span<const bodies::Node> nodes,
                         std::span<const bodies::RigidBody> rigid_bodies,
                         std::span<const Eigen::Matrix3d> turn_s,
                         const bodies::SphereBinding& sphere, double sign, double share) {
  ContactSide side;
  side.sign = sign;
  side.share = share;
  if (sphere.rigid >= 0) {
    const auto index = static_cast<std::size_t>(sphere.rigid);
    const bodies::RigidBody& body = rigid_bodies[index];
    side.body = body.unknown;
    if (body.unknown == bodies::kNoUnknown) return side;
    side.arm_m = body.orientation * sphere.local_m;
    side.spin_rad_s = body.angular_velocity_rad_s;
    side.turn_s = turn_s[index];
    side.press_arm_by_spin_m_s = -bodies::cross_matrix(side.arm_m) * side.turn_s;
    return side;
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(sphere.node_count); ++i) {
    const int unknown = nodes[static_cast<std::size_t>(sphere.nodes[i])].unknown;
    if (unknown == bodies::kNoUnknown) continue;
    const auto at = static_cast<std::size_t>(side.node_count++);
    side.unknowns[at] = unknown;
    side.weights[at] = sphere.weights[i];
  }
  return side;
}

ContactJacobian contact_jacobian(const contact::ContactForce& force,
                                 const contact::ContactDerivatives& derivatives,
                                 JacobianKind jacobian, double stage_s) {
  ContactJacobian result;
  result.is_exact = jacobian == JacobianKind::kExact;
  const Eigen::Matrix3d arm = bodies::cross_matrix(force.arm_m);
  if (result.is_exact) {
    result.friction_N = force.friction_N;
    result.press_N = force.force_N - force.friction_N;
    result.press_by_position = derivatives.force_by_position - derivatives.friction_by_position;
    result.by_position << derivatives.force_by_position,
        bodies::cross_matrix(force.friction_N) * derivatives.arm_by_position -
            arm * derivatives.friction_by_position;
    result.by_motion << derivatives.force_by_velocity, derivatives.force_by_spin,
        -arm * derivatives.friction_by_velocity, -arm * derivatives.friction_by_spin;
    return result;
  }
  const Eigen::Matrix3d& drag = derivatives.drag_N_s_per_m;
  const Eigen::Matrix3d slide = drag * derivatives.across, turn = drag * arm;
  Eigen::Matrix3d stiffness = derivatives.normal_stiffness_N_per_m;
  if (jacobian == JacobianKind::kSymmetric)
    stiffness -= derivatives.sideways_softness_N_per_m * derivatives.across;
  result.by_motion << -stage_s * stiffness - slide, -turn, arm * slide, arm * turn;
  return result;
}

void multiply_add(const ContactJacobian& jacobian, double stage_s, const Eigen::VectorXd& x,
                  Eigen::VectorXd& y) {
  Change change;
  add_change(jacobian.a, stage_s, jacobian.is_exact, x, change);
  add_change(jacobian.b, stage_s, jacobian.is_exact, x, change);
  Eigen::Matrix<double, 6, 1> response;
  response.noalias() = jacobian.by_motion.leftCols<3>() * change.velocity;
  response.noalias() += jacobian.by_motion.rightCols<3>() * change.spin;
  if (jacobian.is_exact) response.noalias() += jacobian.by_position * change.position;
  const Eigen::Vector3d force = -stage_s * response.head<3>(),
                        couple = -stage_s * response.tail<3>();
  push(jacobian.a, force, couple, y);
  push(jacobian.b, force, couple, y);
  if (!jacobian.is_exact) return;
  const Eigen::Vector3d press = jacobian.press_by_position * change.position;
  for (const ContactSide* side : {&jacobian.a, &jacobian.b})
    if (side->body != bodies::kNoUnknown)
      y.segment<3>(side->body + 3) -=
          stage_s * (side->sign * side->press_arm_m.cross(press) +
                     lever_turns(*side, jacobian, x.segment<3>(side->body + 3)));
}

void add_diagonal(const ContactJacobian& jacobian, double stage_s, Eigen::Matrix3Xd& blocks) {
  for (const ContactSide* moved : {&jacobian.a, &jacobian.b}) {
    if (!moved->moves()) continue;
    const SideResponse response = response_of(jacobian, *moved, stage_s);
    for (const ContactSide* pushed : {&jacobian.a, &jacobian.b}) {
      if (moved->body == bodies::kNoUnknown) {
        for (std::size_t i = 0; i < static_cast<std::size_t>(moved->node_count); ++i)
          add_diagonal(*pushed, response.linear, response.press_linear,
                       -stage_s * moved->weights[i], moved->unknowns[i], blocks);
        continue;
      }
      add_diagonal(*pushed, response.linear, response.press_linear, -stage_s, moved->body, blocks);
      add_diagonal(*pushed, response.spin, response.press_spin, -stage_s, moved->body + 3, blocks);
    }
    if (jacobian.is_exact && moved->body != bodies::kNoUnknown)
      for (int i = 0; i < 3; ++i)
        blocks.col(moved->body + 3 + i) -=
            stage_s * lever_turns(*moved, jacobian, Eigen::Vector3d::Unit(i));
  }
}

}  // namespace stillgrid::dynamics
