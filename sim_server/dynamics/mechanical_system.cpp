#include "sim_server/dynamics/mechanical_system.hpp"

#include <algorithm>
#include <array>

#include "sim_server/bodies/rotation.hpp"
#include "sim_server/bodies/sphere_motion.hpp"

namespace stillgrid {
namespace {

Eigen::Matrix3d world_inertia(const RigidBody& body) {
  const Eigen::Matrix3d r = body.orientation.toRotationMatrix();
  return r * body.inertia_kg_m2.asDiagonal() * r.transpose();
}

/// Force of a spring on its node b, and its slopes by b's position and velocity.
struct SpringForce {
  Eigen::Vector3d force_N;
  Eigen::Matrix3d by_position, by_velocity;
};

SpringForce spring_force(const Spring& spring, const Node& a, const Node& b, Slope slope) {
  const Eigen::Vector3d line_m = b.position_m - a.position_m;
  const double length_m = line_m.norm();
  if (length_m < 1e-12)
    return {Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};
  const Eigen::Vector3d n = line_m / length_m;
  const Eigen::Vector3d velocity_m_s = b.velocity_m_s - a.velocity_m_s;
  const double tension_N = spring.stiffness_N_m * (length_m - spring.rest_length_m) +
                           spring.damping_N_s_m * n.dot(velocity_m_s);
  const Eigen::Matrix3d along = n * n.transpose();
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - along;
  const bool exact = slope == Slope::kExact;
  const double sideways_N_m = (exact ? tension_N : std::max(tension_N, 0.0)) / length_m;
  SpringForce result;
  result.force_N = -tension_N * n;
  result.by_position = -spring.stiffness_N_m * along - sideways_N_m * across;
  if (exact)
    result.by_position -= spring.damping_N_s_m / length_m * n * (velocity_m_s.transpose() * across);
  result.by_velocity = -spring.damping_N_s_m * along;
  return result;
}

/// A side's centre, velocity and spin.
struct SideMotion {
  SphereMotion motion;
  Eigen::Vector3d spin_rad_s = Eigen::Vector3d::Zero();
};

ContactMotion relative_motion(const Contact& contact, const SideMotion& a, const SideMotion& b) {
  const ContactShares shares = contact_shares(contact);
  const Eigen::Vector3d origin_m =
      contact.is_plane ? Eigen::Vector3d::Zero().eval() : b.motion.position_m;
  return {a.motion.position_m - origin_m, a.motion.velocity_m_s - b.motion.velocity_m_s,
          shares.a * a.spin_rad_s + shares.b * b.spin_rad_s};
}

SideMotion side_motion(int sphere, const World& world, const Trial& trial) {
  const auto index = static_cast<std::size_t>(sphere);
  const int rigid = world.spheres[index].rigid;
  if (rigid < 0) return {trial.spheres[index]};
  return {trial.spheres[index],
          trial.rigid_bodies[static_cast<std::size_t>(rigid)].angular_velocity_rad_s};
}

SideMotion other_motion(const Contact& contact, const World& world, const Trial& trial) {
  if (contact.b >= 0) return side_motion(contact.b, world, trial);
  return {{contact.position_b_m, contact.velocity_b_m_s}, contact.spin_b_rad_s};
}

/// One side of a contact: which way the force acts on it, and its share of the line of centres.
struct Side {
  const SphereParts* parts;
  double sign;
  double share;
};

/// d(impulse balance of `pushed`) / d(unknown of `moved`).
Eigen::Matrix3d exact_block(const ContactForce& force, const ContactSlopes& slopes,
                            const Side& pushed_side, const SpherePart& pushed,
                            const Side& moved_side, const SpherePart& moved, double step_s) {
  const Eigen::Matrix3d position = moved_side.sign * moved.position_by_unknown;
  const Eigen::Matrix3d velocity = moved_side.sign * moved.velocity_by_unknown;
  Eigen::Matrix3d force_by =
      slopes.force_by_position * position + slopes.force_by_velocity * velocity;
  if (moved.is_rotation) force_by += moved_side.share * slopes.force_by_spin;
  Eigen::Matrix3d block = pushed_side.sign * pushed.lever.transpose() * force_by;
  if (pushed.is_rotation) {
    Eigen::Matrix3d friction_by =
        slopes.friction_by_position * position + slopes.friction_by_velocity * velocity;
    if (moved.is_rotation) friction_by += moved_side.share * slopes.friction_by_spin;
    block +=
        pushed_side.share * (cross_matrix(force.friction_N) * slopes.arm_by_position * position -
                             cross_matrix(force.arm_m) * friction_by);
    // The lever itself turns with the body: d(r x F) = dr x F.
    if (&pushed == &moved)
      block -= pushed_side.sign * cross_matrix(force.force_N) * moved.position_by_unknown;
  }
  return -step_s * block;
}

/// How an unknown moves the slip at the point of contact.
Eigen::Matrix3d slip_by_unknown(const ContactForce& force, const ContactSlopes& slopes,
                                const Side& side, const SpherePart& part) {
  Eigen::Matrix3d slip_by = side.sign * slopes.across * part.lever;
  if (part.is_rotation) slip_by += side.share * cross_matrix(force.arm_m);
  return slip_by;
}

Eigen::Matrix3d definite_block(const ContactForce& force, const ContactSlopes& slopes,
                               const Side& pushed_side, const SpherePart& pushed,
                               const Side& moved_side, const SpherePart& moved, double step_s) {
  return step_s * step_s * pushed_side.sign * moved_side.sign * pushed.lever.transpose() *
             slopes.normal_stiffness_N_m * moved.lever +
         step_s * slip_by_unknown(force, slopes, pushed_side, pushed).transpose() *
             slopes.drag_N_s_m * slip_by_unknown(force, slopes, moved_side, moved);
}

}  // namespace

MechanicalSystem::MechanicalSystem(const World& world, std::span<const Contact> contacts)
    : world_(world),
      contacts_(contacts),
      mass_(Eigen::VectorXd::Ones(world.unknown_count)),
      scale_(Eigen::VectorXd::Ones(world.unknown_count)),
      trial_{world.nodes, world.rigid_bodies, std::vector<SphereMotion>(world.spheres.size())} {
  for (const Node& node : world.nodes)
    if (node.unknown != kNoUnknown) mass_.segment<3>(node.unknown).setConstant(node.mass_kg);
  for (const RigidBody& body : world.rigid_bodies) {
    if (body.unknown == kNoUnknown) continue;
    mass_.segment<3>(body.unknown).setConstant(body.mass_kg);
    mass_.segment<3>(body.unknown + 3).setConstant(body.inertia_kg_m2.maxCoeff());
  }
  scale_ = mass_.cwiseInverse();
  for (const RigidBody& body : world.rigid_bodies)
    if (body.unknown != kNoUnknown) scale_.segment<3>(body.unknown + 3) *= body.reach_m;
}

Eigen::VectorXd MechanicalSystem::velocity() const {
  Eigen::VectorXd u(size());
  for (const Node& node : world_.nodes)
    if (node.unknown != kNoUnknown) u.segment<3>(node.unknown) = node.velocity_m_s;
  for (const RigidBody& body : world_.rigid_bodies)
    if (body.unknown != kNoUnknown) {
      u.segment<3>(body.unknown) = body.velocity_m_s;
      u.segment<3>(body.unknown + 3) = body.angular_velocity_rad_s;
    }
  return u;
}

void MechanicalSystem::place(const Eigen::VectorXd& displacement, const Eigen::VectorXd& u,
                             double time_s) {
  for (std::size_t i = 0; i < trial_.nodes.size(); ++i) {
    Node& node = trial_.nodes[i];
    if (node.unknown == kNoUnknown) continue;
    node.velocity_m_s = u.segment<3>(node.unknown);
    node.position_m = world_.nodes[i].position_m + displacement.segment<3>(node.unknown);
  }
  for (std::size_t i = 0; i < trial_.rigid_bodies.size(); ++i) {
    RigidBody& body = trial_.rigid_bodies[i];
    const RigidBody& before = world_.rigid_bodies[i];
    if (body.unknown == kNoUnknown) {
      const PrescribedState state = prescribed_state(body, world_.time_s + time_s);
      body.position_m = state.position_m;
      body.velocity_m_s = state.velocity_m_s;
      continue;
    }
    body.velocity_m_s = u.segment<3>(body.unknown);
    body.angular_velocity_rad_s = u.segment<3>(body.unknown + 3);
    body.position_m = before.position_m + displacement.segment<3>(body.unknown);
    body.orientation =
        (rotation_of(displacement.segment<3>(body.unknown + 3)) * before.orientation).normalized();
  }
  for (std::size_t i = 0; i < world_.spheres.size(); ++i)
    trial_.spheres[i] = sphere_motion(trial_.nodes, trial_.rigid_bodies, world_.spheres[i]);
}

void MechanicalSystem::momentum(Eigen::VectorXd& momentum) const {
  momentum.resize(size());
  for (const Node& node : trial_.nodes)
    if (node.unknown != kNoUnknown)
      momentum.segment<3>(node.unknown) = node.mass_kg * node.velocity_m_s;
  for (const RigidBody& body : trial_.rigid_bodies) {
    if (body.unknown == kNoUnknown) continue;
    momentum.segment<3>(body.unknown) = body.mass_kg * body.velocity_m_s;
    momentum.segment<3>(body.unknown + 3) = world_inertia(body) * body.angular_velocity_rad_s;
  }
}

void MechanicalSystem::force(double contact_step_s, Eigen::VectorXd& force) {
  force.setZero(size());
  for (const Node& node : trial_.nodes)
    if (node.unknown != kNoUnknown)
      force.segment<3>(node.unknown) = node.mass_kg * world_.gravity_m_s2;
  for (const RigidBody& body : trial_.rigid_bodies)
    if (body.unknown != kNoUnknown)
      force.segment<3>(body.unknown) = body.mass_kg * world_.gravity_m_s2;
  add_springs(force);
  add_contacts(contact_step_s, force);
}

void MechanicalSystem::add_springs(Eigen::VectorXd& force) const {
  for (const Spring& spring : world_.springs) {
    const Node& a = trial_.nodes[static_cast<std::size_t>(spring.a)];
    const Node& b = trial_.nodes[static_cast<std::size_t>(spring.b)];
    const Eigen::Vector3d force_N = spring_force(spring, a, b, Slope::kExact).force_N;
    if (a.unknown != kNoUnknown) force.segment<3>(a.unknown) -= force_N;
    if (b.unknown != kNoUnknown) force.segment<3>(b.unknown) += force_N;
  }
}

void MechanicalSystem::add_contacts(double contact_step_s, Eigen::VectorXd& force) {
  trial_.touching = 0;
  for (const Contact& contact : contacts_) {
    const ContactMotion motion = relative_motion(contact, side_motion(contact.a, world_, trial_),
                                                 other_motion(contact, world_, trial_));
    const ContactForce law = contact_force(contact, motion, contact_step_s, nullptr);
    if (!law.touching) continue;
    ++trial_.touching;
    const ContactShares shares = contact_shares(contact);
    const Eigen::Vector3d couple_N_m = -law.arm_m.cross(law.friction_N);
    push_sphere(world_.spheres[static_cast<std::size_t>(contact.a)], law.force_N,
                shares.a * couple_N_m, force);
    if (contact.b >= 0)
      push_sphere(world_.spheres[static_cast<std::size_t>(contact.b)], -law.force_N,
                  shares.b * couple_N_m, force);
  }
}

/// A force at a sphere's centre, and a couple that only a rigid body can take up.
void MechanicalSystem::push_sphere(const SphereBinding& sphere, const Eigen::Vector3d& force_N,
                                   const Eigen::Vector3d& couple_N_m,
                                   Eigen::VectorXd& force) const {
  if (sphere.rigid >= 0) {
    const RigidBody& body = trial_.rigid_bodies[static_cast<std::size_t>(sphere.rigid)];
    if (body.unknown == kNoUnknown) return;
    const Eigen::Vector3d arm_m = body.orientation * sphere.local_m;
    force.segment<3>(body.unknown) += force_N;
    force.segment<3>(body.unknown + 3) += arm_m.cross(force_N) + couple_N_m;
    return;
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(sphere.node_count); ++i) {
    const int unknown = trial_.nodes[static_cast<std::size_t>(sphere.nodes[i])].unknown;
    if (unknown != kNoUnknown) force.segment<3>(unknown) += sphere.weights[i] * force_N;
  }
}

void MechanicalSystem::jacobian(Slope slope, double stage_s, Eigen::SparseMatrix<double>& matrix) {
  blocks_.reset(size());
  add_inertia_slopes(slope, stage_s);
  add_spring_slopes(slope, stage_s);
  add_contact_slopes(slope, stage_s);
  blocks_.write_to(matrix);
}

void MechanicalSystem::linearise(Slope slope, double stage_s) {
  jacobian(slope, stage_s, matrix_);
  diagonal_.setZero(3, size());
  for (Eigen::Index column = 0; column < size(); ++column)
    for (Eigen::SparseMatrix<double>::InnerIterator entry(matrix_, column); entry; ++entry)
      if (entry.row() / 3 == column / 3) diagonal_(entry.row() % 3, column) = entry.value();
}

void MechanicalSystem::multiply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
  y.noalias() = matrix_ * x;
}

void MechanicalSystem::add_inertia_slopes(Slope slope, double stage_s) {
  for (const Node& node : trial_.nodes)
    if (node.unknown != kNoUnknown)
      blocks_.add(node.unknown, node.unknown, node.mass_kg * Eigen::Matrix3d::Identity());
  for (const RigidBody& body : trial_.rigid_bodies) {
    if (body.unknown == kNoUnknown) continue;
    blocks_.add(body.unknown, body.unknown, body.mass_kg * Eigen::Matrix3d::Identity());
    Eigen::Matrix3d inertia = world_inertia(body);
    if (slope == Slope::kExact) {
      // d(I w) = I dw + d theta x (I w) - I (d theta x w), d theta = h J dw.
      const Eigen::Vector3d& w = body.angular_velocity_rad_s;
      inertia += (inertia * cross_matrix(w) - cross_matrix(inertia * w)) * stage_s *
                 left_jacobian(stage_s * w);
    }
    blocks_.add(body.unknown + 3, body.unknown + 3, inertia);
  }
}

void MechanicalSystem::add_spring_slopes(Slope slope, double stage_s) {
  for (const Spring& spring : world_.springs) {
    const Node& a = trial_.nodes[static_cast<std::size_t>(spring.a)];
    const Node& b = trial_.nodes[static_cast<std::size_t>(spring.b)];
    const SpringForce force = spring_force(spring, a, b, slope);
    const Eigen::Matrix3d block = -stage_s * (stage_s * force.by_position + force.by_velocity);
    if (a.unknown != kNoUnknown) blocks_.add(a.unknown, a.unknown, block);
    if (b.unknown != kNoUnknown) blocks_.add(b.unknown, b.unknown, block);
    if (a.unknown == kNoUnknown || b.unknown == kNoUnknown) continue;
    blocks_.add(a.unknown, b.unknown, -block);
    blocks_.add(b.unknown, a.unknown, -block);
  }
}

void MechanicalSystem::add_contact_slopes(Slope slope, double stage_s) {
  const auto parts_of = [&](int sphere) {
    return sphere < 0 ? SphereParts{}
                      : sphere_parts(trial_.nodes, trial_.rigid_bodies,
                                     world_.spheres[static_cast<std::size_t>(sphere)], stage_s);
  };
  for (const Contact& contact : contacts_) {
    const ContactMotion motion = relative_motion(contact, side_motion(contact.a, world_, trial_),
                                                 other_motion(contact, world_, trial_));
    ContactSlopes slopes;
    const ContactForce force = contact_force(contact, motion, stage_s, &slopes);
    if (!force.touching) continue;
    const SphereParts a = parts_of(contact.a), b = parts_of(contact.b);
    const ContactShares shares = contact_shares(contact);
    const std::array<Side, 2> sides{{{&a, 1.0, shares.a}, {&b, -1.0, shares.b}}};
    const auto block = slope == Slope::kExact ? exact_block : definite_block;
    for (const Side& moved_side : sides)
      for (const SpherePart& moved : moved_side.parts->all())
        for (const Side& pushed_side : sides)
          for (const SpherePart& pushed : pushed_side.parts->all())
            blocks_.add(pushed.unknown, moved.unknown,
                        block(force, slopes, pushed_side, pushed, moved_side, moved, stage_s));
  }
}

}  // namespace stillgrid
