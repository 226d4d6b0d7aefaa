#include "sim_server/dynamics/implicit_euler.hpp"

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

SideMotion side_motion(int sphere, const World& world, std::span<const SphereMotion> motion,
                       std::span<const RigidBody> rigid_bodies) {
  const auto index = static_cast<std::size_t>(sphere);
  const int rigid = world.spheres[index].rigid;
  if (rigid < 0) return {motion[index]};
  return {motion[index], rigid_bodies[static_cast<std::size_t>(rigid)].angular_velocity_rad_s};
}

SideMotion other_motion(const Contact& contact, const World& world,
                        std::span<const SphereMotion> motion,
                        std::span<const RigidBody> rigid_bodies) {
  if (contact.b >= 0) return side_motion(contact.b, world, motion, rigid_bodies);
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

ImplicitEulerStep::ImplicitEulerStep(const World& world, std::span<const Contact> contacts,
                                     double step_s)
    : world_(world),
      contacts_(contacts),
      step_s_(step_s),
      scale_(Eigen::VectorXd::Ones(world.unknown_count)),
      nodes_(world.nodes),
      rigid_bodies_(world.rigid_bodies),
      motion_(world.spheres.size()) {
  for (const Node& node : world.nodes)
    if (node.unknown != kNoUnknown) scale_.segment<3>(node.unknown).setConstant(1.0 / node.mass_kg);
  for (RigidBody& body : rigid_bodies_) {
    if (body.unknown == kNoUnknown) {
      const PrescribedState end = prescribed_state(body, world.time_s + step_s);
      body.position_m = end.position_m;
      body.velocity_m_s = end.velocity_m_s;
      continue;
    }
    scale_.segment<3>(body.unknown).setConstant(1.0 / body.mass_kg);
    scale_.segment<3>(body.unknown + 3).setConstant(body.reach_m / body.inertia_kg_m2.maxCoeff());
  }
}

Eigen::VectorXd ImplicitEulerStep::initial_guess() const {
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

void ImplicitEulerStep::set_state(const Eigen::VectorXd& u) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (nodes_[i].unknown == kNoUnknown) continue;
    nodes_[i].velocity_m_s = u.segment<3>(nodes_[i].unknown);
    nodes_[i].position_m = world_.nodes[i].position_m + step_s_ * nodes_[i].velocity_m_s;
  }
  for (std::size_t i = 0; i < rigid_bodies_.size(); ++i) {
    RigidBody& body = rigid_bodies_[i];
    if (body.unknown == kNoUnknown) continue;
    const RigidBody& before = world_.rigid_bodies[i];
    body.velocity_m_s = u.segment<3>(body.unknown);
    body.angular_velocity_rad_s = u.segment<3>(body.unknown + 3);
    body.position_m = before.position_m + step_s_ * body.velocity_m_s;
    body.orientation =
        (rotation_of(step_s_ * body.angular_velocity_rad_s) * before.orientation).normalized();
  }
}

void ImplicitEulerStep::commit(World& world) const {
  world.nodes = nodes_;
  world.rigid_bodies = rigid_bodies_;
  world.time_s += step_s_;
}

void ImplicitEulerStep::residual(const Eigen::VectorXd& u, Eigen::VectorXd& residual) {
  set_state(u);
  residual.setZero(size());
  add_inertia(residual);
  add_springs(residual);
  add_contacts(residual);
}

void ImplicitEulerStep::add_inertia(Eigen::VectorXd& residual) const {
  const Eigen::Vector3d fall_m_s = step_s_ * world_.gravity_m_s2;
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    if (nodes_[i].unknown != kNoUnknown)
      residual.segment<3>(nodes_[i].unknown) +=
          nodes_[i].mass_kg * (nodes_[i].velocity_m_s - world_.nodes[i].velocity_m_s - fall_m_s);
  for (std::size_t i = 0; i < rigid_bodies_.size(); ++i) {
    const RigidBody &body = rigid_bodies_[i], &before = world_.rigid_bodies[i];
    if (body.unknown == kNoUnknown) continue;
    residual.segment<3>(body.unknown) +=
        body.mass_kg * (body.velocity_m_s - before.velocity_m_s - fall_m_s);
    residual.segment<3>(body.unknown + 3) += world_inertia(body) * body.angular_velocity_rad_s -
                                             world_inertia(before) * before.angular_velocity_rad_s;
  }
}

void ImplicitEulerStep::add_springs(Eigen::VectorXd& residual) const {
  for (const Spring& spring : world_.springs) {
    const Node& a = nodes_[static_cast<std::size_t>(spring.a)];
    const Node& b = nodes_[static_cast<std::size_t>(spring.b)];
    const Eigen::Vector3d impulse_N_s = step_s_ * spring_force(spring, a, b, Slope::kExact).force_N;
    if (a.unknown != kNoUnknown) residual.segment<3>(a.unknown) += impulse_N_s;
    if (b.unknown != kNoUnknown) residual.segment<3>(b.unknown) -= impulse_N_s;
  }
}

void ImplicitEulerStep::add_contacts(Eigen::VectorXd& residual) {
  touching_ = 0;
  for (std::size_t i = 0; i < world_.spheres.size(); ++i)
    motion_[i] = sphere_motion(nodes_, rigid_bodies_, world_.spheres[i]);
  for (const Contact& contact : contacts_) {
    const ContactMotion motion =
        relative_motion(contact, side_motion(contact.a, world_, motion_, rigid_bodies_),
                        other_motion(contact, world_, motion_, rigid_bodies_));
    const ContactForce force = contact_force(contact, motion, step_s_, nullptr);
    if (!force.touching) continue;
    ++touching_;
    const ContactShares shares = contact_shares(contact);
    const Eigen::Vector3d impulse_N_s = step_s_ * force.force_N;
    const Eigen::Vector3d couple_N_m_s = -step_s_ * force.arm_m.cross(force.friction_N);
    push_sphere(world_.spheres[static_cast<std::size_t>(contact.a)], impulse_N_s,
                shares.a * couple_N_m_s, residual);
    if (contact.b >= 0)
      push_sphere(world_.spheres[static_cast<std::size_t>(contact.b)], -impulse_N_s,
                  shares.b * couple_N_m_s, residual);
  }
}

/// An impulse at a sphere's centre, and a couple that only a rigid body can take up.
void ImplicitEulerStep::push_sphere(const SphereBinding& sphere, const Eigen::Vector3d& impulse_N_s,
                                    const Eigen::Vector3d& couple_N_m_s,
                                    Eigen::VectorXd& residual) const {
  if (sphere.rigid >= 0) {
    const RigidBody& body = rigid_bodies_[static_cast<std::size_t>(sphere.rigid)];
    if (body.unknown == kNoUnknown) return;
    const Eigen::Vector3d arm_m = body.orientation * sphere.local_m;
    residual.segment<3>(body.unknown) -= impulse_N_s;
    residual.segment<3>(body.unknown + 3) -= arm_m.cross(impulse_N_s) + couple_N_m_s;
    return;
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(sphere.node_count); ++i) {
    const int unknown = nodes_[static_cast<std::size_t>(sphere.nodes[i])].unknown;
    if (unknown != kNoUnknown) residual.segment<3>(unknown) -= sphere.weights[i] * impulse_N_s;
  }
}

void ImplicitEulerStep::jacobian(Slope slope, Eigen::SparseMatrix<double>& matrix) {
  blocks_.reset(size());
  add_inertia_slopes(slope);
  add_spring_slopes(slope);
  add_contact_slopes(slope);
  blocks_.write_to(matrix);
}

void ImplicitEulerStep::add_inertia_slopes(Slope slope) {
  for (const Node& node : nodes_)
    if (node.unknown != kNoUnknown)
      blocks_.add(node.unknown, node.unknown, node.mass_kg * Eigen::Matrix3d::Identity());
  for (const RigidBody& body : rigid_bodies_) {
    if (body.unknown == kNoUnknown) continue;
    blocks_.add(body.unknown, body.unknown, body.mass_kg * Eigen::Matrix3d::Identity());
    Eigen::Matrix3d inertia = world_inertia(body);
    if (slope == Slope::kExact) {
      // d(I w) = I dw + d theta x (I w) - I (d theta x w), d theta = h J dw.
      const Eigen::Vector3d& w = body.angular_velocity_rad_s;
      inertia += (inertia * cross_matrix(w) - cross_matrix(inertia * w)) * step_s_ *
                 left_jacobian(step_s_ * w);
    }
    blocks_.add(body.unknown + 3, body.unknown + 3, inertia);
  }
}

void ImplicitEulerStep::add_spring_slopes(Slope slope) {
  for (const Spring& spring : world_.springs) {
    const Node& a = nodes_[static_cast<std::size_t>(spring.a)];
    const Node& b = nodes_[static_cast<std::size_t>(spring.b)];
    const SpringForce force = spring_force(spring, a, b, slope);
    const Eigen::Matrix3d block = -step_s_ * (step_s_ * force.by_position + force.by_velocity);
    if (a.unknown != kNoUnknown) blocks_.add(a.unknown, a.unknown, block);
    if (b.unknown != kNoUnknown) blocks_.add(b.unknown, b.unknown, block);
    if (a.unknown == kNoUnknown || b.unknown == kNoUnknown) continue;
    blocks_.add(a.unknown, b.unknown, -block);
    blocks_.add(b.unknown, a.unknown, -block);
  }
}

void ImplicitEulerStep::add_contact_slopes(Slope slope) {
  const auto parts_of = [&](int sphere) {
    return sphere < 0 ? SphereParts{}
                      : sphere_parts(nodes_, rigid_bodies_,
                                     world_.spheres[static_cast<std::size_t>(sphere)], step_s_);
  };
  for (const Contact& contact : contacts_) {
    const ContactMotion motion =
        relative_motion(contact, side_motion(contact.a, world_, motion_, rigid_bodies_),
                        other_motion(contact, world_, motion_, rigid_bodies_));
    ContactSlopes slopes;
    const ContactForce force = contact_force(contact, motion, step_s_, &slopes);
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
                        block(force, slopes, pushed_side, pushed, moved_side, moved, step_s_));
  }
}

}  // namespace stillgrid
