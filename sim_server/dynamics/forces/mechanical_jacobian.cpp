// How the momentum and the forces of a mechanical system change with its velocities.

#include "sim_server/bodies/rotation.hpp"
#include "sim_server/dynamics/forces/mechanical_system.hpp"

namespace stillgrid::dynamics {

void MechanicalSystem::find_links() {
  for (const auto springs : springs_)
    for (const bodies::Spring& spring : springs) {
      const int a = trial_.nodes[static_cast<std::size_t>(spring.a)].unknown;
      const int b = trial_.nodes[static_cast<std::size_t>(spring.b)].unknown;
      if (a != bodies::kNoUnknown && b != bodies::kNoUnknown) links_.push_back({a / 3, b / 3});
    }
  triangle_.set_pattern(static_cast<int>(size() / 3), links_);
}

void MechanicalSystem::fill_triangle(JacobianKind kind) {
  triangle_.set_zero();
  for (const InertiaJacobian& own : inertia_jacobians_)
    triangle_.diagonal(own.unknown / 3) = own.block;
  std::size_t link = 0;
  for (const auto springs : springs_)
    add_spring_blocks(springs, trial_.nodes, kind, stage_s_, link, triangle_);
  for (Eigen::Index i = 0; i < size(); i += 3)
    diagonal_.middleCols<3>(i) = triangle_.diagonal(static_cast<int>(i / 3));
}

void MechanicalSystem::linearise(JacobianKind kind, double stage_s) {
  is_exact_ = kind == JacobianKind::kExact;
  stage_s_ = stage_s;
  add_inertia_jacobians(kind);
  add_joint_jacobians(kind);
  add_contact_jacobians(kind);
  diagonal_.setZero(3, size());
  const auto add = [&](int unknown, const Eigen::Matrix3d& block) {
    if (unknown != bodies::kNoUnknown) diagonal_.middleCols<3>(unknown) += block;
  };
  if (is_exact_) {
    add_spring_jacobians(kind);
    for (const InertiaJacobian& own : inertia_jacobians_) add(own.unknown, own.block);
    for (const SpringJacobian& spring : spring_jacobians_) {
      const Eigen::Matrix3d block = spring.block();
      add(spring.a, block);
      add(spring.b, block);
    }
  } else {
    if (links_.empty()) find_links();
    fill_triangle(kind);
  }
  for (const JointJacobian& joint : joint_jacobians_) add_diagonal(joint, diagonal_);
  for (const ContactJacobian& contact : contact_jacobians_)
    add_diagonal(contact, stage_s, diagonal_);
}

void MechanicalSystem::multiply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
  if (is_exact_) {
    y.resize(size());
    for (const InertiaJacobian& own : inertia_jacobians_)
      y.segment<3>(own.unknown).noalias() = own.block * x.segment<3>(own.unknown);
    multiply_add(spring_jacobians_, x, y);
  } else {
    triangle_.multiply(x, y);
  }
  add_rest(x, y);
}

void MechanicalSystem::add_rest(const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
  for (const JointJacobian& joint : joint_jacobians_) multiply_add(joint, x, y);
  for (const ContactJacobian& contact : contact_jacobians_) multiply_add(contact, stage_s_, x, y);
}

void MechanicalSystem::add_spring_jacobians(JacobianKind kind) {
  spring_jacobians_.clear();
  for (const auto springs : springs_)
    dynamics::add_spring_jacobians(springs, trial_.nodes, kind, stage_s_, spring_jacobians_);
}

void MechanicalSystem::add_inertia_jacobians(JacobianKind kind) {
  inertia_jacobians_.clear();
  for (const bodies::Node& node : trial_.nodes)
    if (node.unknown != bodies::kNoUnknown)
      inertia_jacobians_.push_back({node.unknown, node.mass_kg * Eigen::Matrix3d::Identity()});
  for (std::size_t i = 0; i < trial_.rigid_bodies.size(); ++i) {
    const bodies::RigidBody& body = trial_.rigid_bodies[i];
    if (body.unknown == bodies::kNoUnknown) continue;
    inertia_jacobians_.push_back({body.unknown, body.mass_kg * Eigen::Matrix3d::Identity()});
    turn_s_[i] = stage_s_ * bodies::left_jacobian(turned_rad_[i]);
    Eigen::Matrix3d inertia = bodies::world_inertia_kg_m2(body);
    if (kind == JacobianKind::kExact) {
      // d(I w) = I dw + d theta x (I w) - I (d theta x w), d theta = turn_s dw.
      const Eigen::Vector3d& w = body.angular_velocity_rad_s;
      inertia +=
          (inertia * bodies::cross_matrix(w) - bodies::cross_matrix(inertia * w)) * turn_s_[i];
    }
    inertia_jacobians_.push_back({body.unknown + 3, inertia});
  }
}

void MechanicalSystem::add_contact_jacobians(JacobianKind kind) {
  contact_jacobians_.clear();
  const auto side = [&](const bodies::SphereBinding& sphere, double sign, double share) {
    ContactSide own = contact_side(trial_.nodes, trial_.rigid_bodies, turn_s_, sphere, sign, share);
    if (kind != JacobianKind::kExact || levers_ == Levers::kAtEnd || sphere.rigid < 0) return own;
    const auto rigid = static_cast<std::size_t>(sphere.rigid);
    const Eigen::Vector3d start_m = world_->rigid_bodies[rigid].orientation * sphere.local_m;
    own.press_arm_m = press_arm_m(sphere);
    own.press_arm_by_spin_m_s = stage_s_ * bodies::mean_arm_by_turn(turned_rad_[rigid], start_m);
    return own;
  };
  find_touching();
  contact::Contact room;
  for (const int index : touching_) {
    const Candidate& candidate = candidates_[static_cast<std::size_t>(index)];
    const contact::Contact& contact = contact_at(candidate, room);
    contact::ContactDerivatives jacobians;
    const contact::ContactForce force =
        contact::contact_force(contact, motion_of(candidate), stage_s_, &jacobians);
    if (!force.touching) continue;
    const contact::ContactShares shares = contact::contact_shares(contact);
    ContactJacobian& own =
        contact_jacobians_.emplace_back(contact_jacobian(force, jacobians, kind, stage_s_));
    own.a = side(binding_of(candidate, contact.a), 1.0, shares.a);
    if (contact.b >= 0) own.b = side(binding_of(candidate, contact.b), -1.0, shares.b);
  }
}

}  // namespace stillgrid::dynamics
