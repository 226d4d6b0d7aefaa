#include "sim_server/dynamics/forces/mechanical_system.hpp"

#include <algorithm>

#include "sim_server/bodies/rotation.hpp"
#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/contact/sticking.hpp"

namespace stillgrid::dynamics {
namespace {

bool is_awake(const bodies::World& world, const bodies::SphereBinding& sphere) {
  if (sphere.rigid >= 0)
    return world.rigid_bodies[static_cast<std::size_t>(sphere.rigid)].unknown != bodies::kNoUnknown;
  return !world.bodies[static_cast<std::size_t>(sphere.body)].is_sleeping;
}

bool moves(const bodies::World& world, int number) {
  if (number < 0) return false;
  if (!bodies::is_field(world, number))
    return is_awake(world, world.spheres[static_cast<std::size_t>(number)]);
  const int rigid = bodies::rigid_of(world, number);
  return rigid >= 0 &&
         world.rigid_bodies[static_cast<std::size_t>(rigid)].unknown != bodies::kNoUnknown;
}

Eigen::Vector3d sphere_position_m(const bodies::World& world, int sphere) {
  return bodies::sphere_motion(world, world.spheres[static_cast<std::size_t>(sphere)]).position_m;
}

}  // namespace

void MechanicalSystem::take(const bodies::World& world, std::span<const contact::Contact> contacts,
                            std::span<const Eigen::Vector3d> stretches_m, Levers levers) {
  world_ = &world;
  levers_ = levers;
  contacts_ = contacts;
  sticks_ = !stretches_m.empty();
  mass_.setOnes(world.unknown_count);
  scale_.setOnes(world.unknown_count);
  trial_.nodes = world.nodes;
  trial_.rigid_bodies = world.rigid_bodies;
  trial_.spheres.resize(world.spheres.size());
  for (std::size_t i = 0; i < world.spheres.size(); ++i)
    if (!is_awake(world, world.spheres[i]))
      trial_.spheres[i] = bodies::sphere_motion(world, world.spheres[i]);
  turned_rad_.assign(world.rigid_bodies.size(), Eigen::Vector3d::Zero());
  mean_turns_.assign(world.rigid_bodies.size(), Eigen::Matrix3d::Zero());
  turn_s_.resize(world.rigid_bodies.size());
  candidates_.clear();
  touches_.clear();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const contact::Contact& contact = contacts[i];
    if (!moves(world, contact.a) && !moves(world, contact.b)) continue;
    Candidate& own = candidates_.emplace_back();
    own.contact = static_cast<int>(i);
    own.a = contact.a;
    own.b = contact.b;
    own.bounding_radius_m = contact.radius_a_m + contact.radius_b_m;
    if (sticks_ && !contact.is_tool) own.stretch_m = stretches_m[i];
    if (bodies::is_field(world, own.a) || bodies::is_field(world, own.b))
      add_touch(own);
    else if (levers == Levers::kMean && !contact.is_plane && contact.depth_before_m > 0.0)
      own.start_m = sphere_position_m(world, contact.a) -
                    (contact.b >= 0 ? sphere_position_m(world, contact.b) : contact.start_b_m);
  }
  springs_.clear();
  const std::span<const bodies::Spring> springs = world.springs;
  for (const bodies::BodyRange& body : world.bodies)
    if (!body.is_sleeping && body.spring_count > 0)
      springs_.push_back(springs.subspan(static_cast<std::size_t>(body.first_spring),
                                         static_cast<std::size_t>(body.spring_count)));
  take_joints();
  for (const bodies::Node& node : world.nodes)
    if (node.unknown != bodies::kNoUnknown)
      mass_.segment<3>(node.unknown).setConstant(node.mass_kg);
  for (const bodies::RigidBody& body : world.rigid_bodies) {
    if (body.unknown == bodies::kNoUnknown) continue;
    mass_.segment<3>(body.unknown).setConstant(body.mass_kg);
    mass_.segment<3>(body.unknown + 3).setConstant(body.inertia_kg_m2.maxCoeff());
  }
  links_.clear();
  scale_ = mass_.cwiseInverse();
  for (const bodies::RigidBody& body : world.rigid_bodies)
    if (body.unknown != bodies::kNoUnknown)
      scale_.segment<3>(body.unknown + 3) *= body.bounding_radius_m;
}

Eigen::VectorXd MechanicalSystem::velocity() const {
  Eigen::VectorXd u(size());
  for (const bodies::Node& node : world_->nodes)
    if (node.unknown != bodies::kNoUnknown) u.segment<3>(node.unknown) = node.velocity_m_s;
  for (const bodies::RigidBody& body : world_->rigid_bodies)
    if (body.unknown != bodies::kNoUnknown) {
      u.segment<3>(body.unknown) = body.velocity_m_s;
      u.segment<3>(body.unknown + 3) = body.angular_velocity_rad_s;
    }
  return u;
}

void MechanicalSystem::place(const Eigen::VectorXd& displacement, const Eigen::VectorXd& u,
                             double time_s) {
  time_s_ = time_s;
  for (std::size_t i = 0; i < trial_.nodes.size(); ++i) {
    bodies::Node& node = trial_.nodes[i];
    if (node.unknown == bodies::kNoUnknown) continue;
    node.velocity_m_s = u.segment<3>(node.unknown);
    node.position_m = world_->nodes[i].position_m + displacement.segment<3>(node.unknown);
  }
  for (std::size_t i = 0; i < trial_.rigid_bodies.size(); ++i) {
    bodies::RigidBody& body = trial_.rigid_bodies[i];
    const bodies::RigidBody& before = world_->rigid_bodies[i];
    if (!body.free) {
      const bodies::PrescribedState state = bodies::prescribed_state(body, world_->time_s + time_s);
      body.position_m = state.position_m;
      body.velocity_m_s = state.velocity_m_s;
    }
    if (body.unknown == bodies::kNoUnknown) continue;
    turned_rad_[i] = displacement.segment<3>(body.unknown + 3);
    body.velocity_m_s = u.segment<3>(body.unknown);
    body.angular_velocity_rad_s = u.segment<3>(body.unknown + 3);
    body.position_m = before.position_m + displacement.segment<3>(body.unknown);
    body.orientation = (bodies::rotation_of(turned_rad_[i]) * before.orientation).normalized();
    if (levers_ == Levers::kMean)
      mean_turns_[i] =
          bodies::left_jacobian(turned_rad_[i]).transpose() - Eigen::Matrix3d::Identity();
  }
  for (const bodies::BodyRange& range : world_->bodies) {
    if (range.is_sleeping) continue;
    for (int i = range.first_sphere; i < range.first_sphere + range.sphere_count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      trial_.spheres[at] =
          bodies::sphere_motion(trial_.nodes, trial_.rigid_bodies, world_->spheres[at]);
    }
  }
  for (Touch& touch : touches_) place(touch);
}

void MechanicalSystem::momentum(const Eigen::VectorXd& u, Eigen::VectorXd& momentum) const {
  momentum.resize(size());
  for (const bodies::Node& node : trial_.nodes)
    if (node.unknown != bodies::kNoUnknown)
      momentum.segment<3>(node.unknown) = node.mass_kg * u.segment<3>(node.unknown);
  for (const bodies::RigidBody& body : trial_.rigid_bodies) {
    if (body.unknown == bodies::kNoUnknown) continue;
    momentum.segment<3>(body.unknown) = body.mass_kg * u.segment<3>(body.unknown);
    momentum.segment<3>(body.unknown + 3) =
        bodies::world_inertia_kg_m2(body) * u.segment<3>(body.unknown + 3);
  }
}

void MechanicalSystem::force(double contact_step_s, Eigen::VectorXd& force) {
  force.setZero(size());
  for (const bodies::Node& node : trial_.nodes)
    if (node.unknown != bodies::kNoUnknown)
      force.segment<3>(node.unknown) = node.mass_kg * world_->gravity_m_s2;
  for (const bodies::RigidBody& body : trial_.rigid_bodies)
    if (body.unknown != bodies::kNoUnknown)
      force.segment<3>(body.unknown) = body.mass_kg * world_->gravity_m_s2;
  for (const auto springs : springs_)
    for (const bodies::Spring& spring : springs) {
      const bodies::Node& a = trial_.nodes[static_cast<std::size_t>(spring.a)];
      const bodies::Node& b = trial_.nodes[static_cast<std::size_t>(spring.b)];
      const Eigen::Vector3d force_N = spring_force_N(spring, a, b);
      if (a.unknown != bodies::kNoUnknown) force.segment<3>(a.unknown) -= force_N;
      if (b.unknown != bodies::kNoUnknown) force.segment<3>(b.unknown) += force_N;
    }
  add_joint_forces(force);
  add_contact_forces(contact_step_s, force);
}

/// Most contacts are only possible: what does not touch is told apart here, cheaply.
void MechanicalSystem::find_touching() {
  touching_.clear();
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const Candidate& own = candidates_[i];
    if (own.touch >= 0) {
      if (touches_[static_cast<std::size_t>(own.touch)].at.depth_m < 0.0) continue;
    } else if (own.b >= 0) {
      const Eigen::Vector3d line_m = trial_.spheres[static_cast<std::size_t>(own.a)].position_m -
                                     trial_.spheres[static_cast<std::size_t>(own.b)].position_m;
      // By a little too many: rounding is the contact law's affair.
      if (line_m.squaredNorm() > (1.0 + 1e-9) * own.bounding_radius_m * own.bounding_radius_m)
        continue;
    }
    touching_.push_back(static_cast<int>(i));
  }
}

contact::SideMotion MechanicalSystem::side_of(const Candidate& candidate, int number,
                                              bool sticks) const {
  const bodies::SphereMotion& motion =
      bodies::is_field(*world_, number) ? touches_[static_cast<std::size_t>(candidate.touch)].motion
                                        : trial_.spheres[static_cast<std::size_t>(number)];
  contact::SideMotion side{motion.position_m, motion.velocity_m_s};
  const int rigid = bodies::rigid_of(*world_, number);
  if (rigid < 0) return side;
  const bodies::RigidBody& body = trial_.rigid_bodies[static_cast<std::size_t>(rigid)];
  side.spin_rad_s = body.angular_velocity_rad_s;
  // What is led slides by the way it takes: what sticks to it goes with it.
  if (sticks && !body.free && time_s_ > 0.0) {
    const Eigen::Vector3d& start_m =
        world_->rigid_bodies[static_cast<std::size_t>(rigid)].position_m;
    side.velocity_m_s = (body.position_m - start_m) / time_s_;
  }
  return side;
}

contact::ContactMotion MechanicalSystem::motion_of(const Candidate& candidate) const {
  const contact::Contact& contact = contacts_[static_cast<std::size_t>(candidate.contact)];
  const bool sticks = sticks_ && !contact.is_tool;
  contact::ContactMotion motion = contact::relative_motion(
      contact, side_of(candidate, contact.a, sticks),
      contact.b >= 0 ? side_of(candidate, contact.b, sticks) : contact::kinematic_side(contact));
  if (sticks) motion.sticking = contact::Sticking{candidate.stretch_m, time_s_};
  motion.start_m = candidate.start_m;
  return motion;
}

/// By how much the arm by which a contact presses is not the sphere's own at the end.
Eigen::Vector3d MechanicalSystem::press_arm_m(const bodies::SphereBinding& sphere) const {
  if (levers_ == Levers::kAtEnd || sphere.rigid < 0) return Eigen::Vector3d::Zero();
  const auto rigid = static_cast<std::size_t>(sphere.rigid);
  return mean_turns_[rigid] * (trial_.rigid_bodies[rigid].orientation * sphere.local_m);
}

void MechanicalSystem::add_contact_forces(double contact_step_s, Eigen::VectorXd& force) {
  find_touching();
  trial_.touching = 0;
  contact::Contact room;
  for (const int index : touching_) {
    const Candidate& candidate = candidates_[static_cast<std::size_t>(index)];
    const contact::Contact& contact = contact_at(candidate, room);
    const contact::ContactForce law =
        contact::contact_force(contact, motion_of(candidate), contact_step_s, nullptr);
    if (!law.touching) continue;
    ++trial_.touching;
    const contact::ContactShares shares = contact::contact_shares(contact);
    const Eigen::Vector3d couple_N_m = -law.arm_m.cross(law.friction_N);
    const auto push = [&](int number, double sign, double share) {
      const bodies::SphereBinding& sphere = binding_of(candidate, number);
      const Eigen::Vector3d press_N = sign * (law.force_N - law.friction_N);
      push_sphere(sphere, sign * law.force_N,
                  share * couple_N_m + press_arm_m(sphere).cross(press_N), force);
    };
    push(contact.a, 1.0, shares.a);
    if (contact.b >= 0) push(contact.b, -1.0, shares.b);
  }
}

void MechanicalSystem::push_sphere(const bodies::SphereBinding& sphere,
                                   const Eigen::Vector3d& force_N,
                                   const Eigen::Vector3d& couple_N_m,
                                   Eigen::VectorXd& force) const {
  if (sphere.rigid >= 0) {
    const bodies::RigidBody& body = trial_.rigid_bodies[static_cast<std::size_t>(sphere.rigid)];
    if (body.unknown == bodies::kNoUnknown) return;
    const Eigen::Vector3d arm_m = body.orientation * sphere.local_m;
    force.segment<3>(body.unknown) += force_N;
    force.segment<3>(body.unknown + 3) += arm_m.cross(force_N) + couple_N_m;
    return;
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(sphere.node_count); ++i) {
    const int unknown = trial_.nodes[static_cast<std::size_t>(sphere.nodes[i])].unknown;
    if (unknown != bodies::kNoUnknown) force.segment<3>(unknown) += sphere.weights[i] * force_N;
  }
}

Eigen::Vector3d MechanicalSystem::velocity_of(const bodies::SphereBinding& sphere,
                                              const Eigen::VectorXd& u) const {
  if (sphere.rigid >= 0) {
    const bodies::RigidBody& body = trial_.rigid_bodies[static_cast<std::size_t>(sphere.rigid)];
    if (body.unknown == bodies::kNoUnknown) return Eigen::Vector3d::Zero();
    const Eigen::Vector3d arm_m = body.orientation * sphere.local_m;
    return u.segment<3>(body.unknown) + u.segment<3>(body.unknown + 3).cross(arm_m);
  }
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < static_cast<std::size_t>(sphere.node_count); ++i) {
    const int unknown = trial_.nodes[static_cast<std::size_t>(sphere.nodes[i])].unknown;
    if (unknown != bodies::kNoUnknown) velocity += sphere.weights[i] * u.segment<3>(unknown);
  }
  return velocity;
}

}  // namespace stillgrid::dynamics
