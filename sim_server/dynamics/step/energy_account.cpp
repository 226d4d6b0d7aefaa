#include "sim_server/dynamics/step/energy_account.hpp"

#include <algorithm>

#include "sim_server/bodies/joints.hpp"
#include "sim_server/bodies/rotation.hpp"
#include "sim_server/contact/field_touch.hpp"

namespace stillgrid::dynamics {
namespace {

/// Pre: contact.is_tool.
std::size_t hand_of(const contact::Contact& contact) {
  return static_cast<std::size_t>(contact.hand);
}

/// One side of a contact over a step.
struct Side : contact::SideMotion {
  bool is_kinematic = false;
  Eigen::Vector3d displacement_m = Eigen::Vector3d::Zero();  // over the step, of a given side
  Eigen::Vector3d start_m = Eigen::Vector3d::Zero();
};

Side side_of(int sphere, const bodies::World& before, const Trial& after) {
  const auto index = static_cast<std::size_t>(sphere);
  const bodies::SphereMotion& motion = after.spheres[index];
  Side side{{motion.position_m, motion.velocity_m_s}};
  side.start_m = bodies::sphere_motion(before, before.spheres[index]).position_m;
  if (before.spheres[index].rigid < 0) return side;
  const auto rigid = static_cast<std::size_t>(before.spheres[index].rigid);
  side.spin_rad_s = after.rigid_bodies[rigid].angular_velocity_rad_s;
  side.is_kinematic = !before.rigid_bodies[rigid].free;
  side.displacement_m =
      after.rigid_bodies[rigid].position_m - before.rigid_bodies[rigid].position_m;
  return side;
}

Side other_side(const contact::Contact& contact, const bodies::World& before, const Trial& after) {
  if (contact.b >= 0) return side_of(contact.b, before, after);
  return {contact::kinematic_side(contact, 1.0), true, contact.position_b_m - contact.start_b_m,
          contact.start_b_m};
}

/// A contact as it is at the step's end, and its sides.
struct Sides {
  contact::Contact contact;
  Side a, b;
};

/// A field's: the tangent sphere at the end, that of the start where it was.
Side field_side(const bodies::FieldBody& field, const contact::FieldTouch& start,
                const contact::FieldTouch& end, const bodies::World& before, const Trial& after) {
  Side side{{end.centre_m, Eigen::Vector3d::Zero()}};
  side.start_m = start.centre_m;
  side.is_kinematic = true;
  if (field.rigid < 0) return side;
  const auto rigid = static_cast<std::size_t>(field.rigid);
  const bodies::RigidBody& body = after.rigid_bodies[rigid];
  side.is_kinematic = !body.free;
  side.displacement_m = body.position_m - before.rigid_bodies[rigid].position_m;
  side.spin_rad_s = body.angular_velocity_rad_s;
  side.velocity_m_s =
      body.velocity_m_s + body.angular_velocity_rad_s.cross(end.centre_m - body.position_m);
  return side;
}

Sides sides_of(const contact::Contact& contact, const bodies::World& before, const Trial& after) {
  const bool is_first = bodies::is_field(before, contact.a);
  if (!is_first && !(contact.b >= 0 && bodies::is_field(before, contact.b)))
    return {contact, side_of(contact.a, before, after), other_side(contact, before, after)};
  const bodies::FieldBody& field = bodies::field_of(before, is_first ? contact.a : contact.b);
  const Side other =
      is_first ? other_side(contact, before, after) : side_of(contact.a, before, after);
  const double radius_m = is_first ? contact.radius_b_m : contact.radius_a_m;
  const contact::FieldTouch start = contact::touch_of(
      field, contact::pose_of(field, before.rigid_bodies), other.start_m, radius_m);
  const contact::FieldTouch end = contact::touch_of(
      field, contact::pose_of(field, after.rigid_bodies), other.position_m, radius_m);
  const Side own = field_side(field, start, end, before, after);
  return {contact::scaled(contact, end), is_first ? own : other, is_first ? other : own};
}

/// How much less the force of a contact's spring on a is at the end than in the mean of both ends.
Eigen::Vector3d short_of_mean_N(const contact::Contact& contact, const Side& a, const Side& b) {
  const auto spring_N = [&contact](const Eigen::Vector3d& line_m) -> Eigen::Vector3d {
    return contact.material.stiffness_N_per_m *
           std::max(0.0, contact::contact_depth_m(contact, line_m)) * line_m.stableNormalized();
  };
  return 0.5 * (spring_N(a.start_m - b.start_m) - spring_N(a.position_m - b.position_m));
}

/// friction_N: where it sticks; null: as the law has it. start_stretch_m: of what sticks, of a step
/// that goes by both its ends' forces; null: by its end's.
EnergyFlow contact_flow(const contact::Contact& contact, Side a, Side b, double duration_s,
                        const Eigen::Vector3d* friction_N, const Eigen::Vector3d* start_stretch_m) {
  if (friction_N != nullptr)  // what is led slides by its way
    for (Side* side : {&a, &b})
      if (side->is_kinematic) side->velocity_m_s = side->displacement_m / duration_s;
  const contact::ContactShares shares = contact::contact_shares(contact);
  const contact::ContactMotion motion = contact::relative_motion(contact, a, b);
  contact::ContactForce force = contact::contact_force(contact, motion, duration_s, nullptr);
  const bool is_given = a.is_kinematic || b.is_kinematic;
  const bool by_mean = start_stretch_m != nullptr && is_given && !contact.is_plane;
  EnergyFlow flow;
  if (!force.touching && !by_mean) return flow;
  Eigen::Vector3d normal_load_N = force.force_N - force.friction_N;
  if (friction_N != nullptr) force.friction_N = *friction_N;
  const double deepening_m = std::max(0.0, force.depth_m - std::max(contact.depth_before_m, 0.0));
  flow.contact_damping_J =
      (normal_load_N.norm() - contact.material.stiffness_N_per_m * force.depth_m) * deepening_m;
  if (by_mean) {
    normal_load_N += short_of_mean_N(contact, a, b);
    force.friction_N -=
        0.5 * (force.friction_N + contact.material.stiffness_N_per_m * *start_stretch_m);
  }
  flow.friction_J = -duration_s * force.friction_N.dot(motion.velocity_m_s -
                                                       motion.spin_rad_s.cross(force.arm_m));
  // The points of contact turn with their spheres.
  if (b.is_kinematic) {
    flow.given_J = normal_load_N.dot(b.displacement_m) +
                   duration_s * force.friction_N.dot(b.velocity_m_s +
                                                     shares.b * b.spin_rad_s.cross(force.arm_m));
    if (contact.is_tool) flow.tool_J[hand_of(contact)] = flow.given_J;
  }
  if (a.is_kinematic)
    flow.given_J -= normal_load_N.dot(a.displacement_m) +
                    duration_s * force.friction_N.dot(a.velocity_m_s -
                                                      shares.a * a.spin_rad_s.cross(force.arm_m));
  return flow;
}

EnergyFlow contact_flow(std::size_t i, const bodies::World& before, const Trial& after,
                        std::span<const contact::Contact> contacts, double duration_s) {
  const Sides sides = sides_of(contacts[i], before, after);
  return contact_flow(sides.contact, sides.a, sides.b, duration_s,
                      after.friction_N.empty() ? nullptr : &after.friction_N[i],
                      after.start_stretches_m.empty() ? nullptr : &after.start_stretches_m[i]);
}

/// Of its spring, at the step's start.
double stored_J(const contact::Contact& contact) {
  const double depth_m = std::max(0.0, contact.depth_before_m);
  return 0.5 * contact.map_scale_before * contact.material.stiffness_N_per_m * depth_m * depth_m;
}

/// What leads an end of a joint gives by its spring along its way, and by its damper along its
/// velocity. Implicit Euler takes both as they are at the step's end. Of other methods the spring's
/// force is the mean of the step's ends, and the velocity that of the way.
EnergyFlow joint_flow(const bodies::Joint& joint, const bodies::World& before, const Trial& after,
                      double duration_s) {
  const auto motion = [](const bodies::JointEnd& end, const auto& world) {
    return bodies::end_motion(end, world.nodes, world.rigid_bodies);
  };
  const auto is_kinematic = [&](const bodies::JointEnd& end) {
    return end.rigid >= 0 && !before.rigid_bodies[static_cast<std::size_t>(end.rigid)].free;
  };
  bodies::EndMotion a = motion(joint.a, after), b = motion(joint.b, after);
  const bodies::EndMotion start_a = motion(joint.a, before), start_b = motion(joint.b, before);
  const Eigen::Vector3d way_a_m = a.centre_m - start_a.centre_m;
  const Eigen::Vector3d way_b_m = b.centre_m - start_b.centre_m;
  if (!after.takes_end_forces && is_kinematic(joint.a)) a.velocity_m_s = way_a_m / duration_s;
  if (!after.takes_end_forces && is_kinematic(joint.b)) b.velocity_m_s = way_b_m / duration_s;
  const bodies::JointPull pull = bodies::joint_pull(joint, a, b);
  Eigen::Vector3d spring_N = pull.spring_N;
  if (!after.takes_end_forces)
    spring_N = 0.5 * (spring_N + bodies::joint_pull(joint, start_a, start_b).spring_N);
  EnergyFlow flow;
  flow.spring_damping_J = -duration_s * pull.damper_N.dot(pull.velocity_m_s);
  if (is_kinematic(joint.b))
    flow.given_J += spring_N.dot(way_b_m) + duration_s * pull.damper_N.dot(b.velocity_m_s);
  if (is_kinematic(joint.a))
    flow.given_J -= spring_N.dot(way_a_m) + duration_s * pull.damper_N.dot(a.velocity_m_s);
  return flow;
}

}  // namespace

double contact_energy_J(std::span<const contact::Contact> contacts) {
  double energy_J = 0.0;
  for (const contact::Contact& contact : contacts) energy_J += stored_J(contact);
  return energy_J;
}

namespace {

double overlap_energy_J(const bodies::World& world,
                        const std::vector<contact::ToolSphereMotion>& tool) {
  bodies::World awake = world;
  for (bodies::BodyRange& body : awake.bodies) body.is_sleeping = false;
  bodies::number_unknowns(awake);
  contact::Detection detection(awake, 0.0);
  detection.find_contacts(awake, 0.0);
  detection.find_tool_contacts(awake, tool);
  return contact_energy_J(detection.contacts());
}

}  // namespace

double kinetic_energy_J(const bodies::World& world, const bodies::BodyRange& body) {
  double energy_J = 0.0;
  for (int i = 0; i < body.node_count; ++i) {
    const bodies::Node& node = world.nodes[static_cast<std::size_t>(body.first_node + i)];
    if (!node.pinned) energy_J += 0.5 * node.mass_kg * node.velocity_m_s.squaredNorm();
  }
  if (body.rigid < 0) return energy_J;
  const bodies::RigidBody& rigid = world.rigid_bodies[static_cast<std::size_t>(body.rigid)];
  return rigid.free ? energy_J + bodies::kinetic_energy_J(rigid) : energy_J;
}

Energies energies_without_contacts(const bodies::World& world) {
  Energies sum;
  for (const bodies::BodyRange& body : world.bodies) sum.kinetic_J += kinetic_energy_J(world, body);
  for (const bodies::Node& node : world.nodes)
    if (!node.pinned) sum.gravity_J -= node.mass_kg * world.gravity_m_s2.dot(node.position_m);
  for (const bodies::RigidBody& body : world.rigid_bodies)
    if (body.free) sum.gravity_J -= body.mass_kg * world.gravity_m_s2.dot(body.position_m);
  for (const bodies::Spring& spring : world.springs)
    sum.springs_J +=
        bodies::spring_energy_J(spring, world.nodes[static_cast<std::size_t>(spring.a)],
                                world.nodes[static_cast<std::size_t>(spring.b)]);
  for (const bodies::Joint& joint : world.joints)
    sum.springs_J += bodies::joint_energy_J(joint, world.nodes, world.rigid_bodies);
  return sum;
}

Energies energies(const bodies::World& world, const std::vector<contact::ToolSphereMotion>& tool) {
  Energies sum = energies_without_contacts(world);
  sum.contacts_J = overlap_energy_J(world, tool);
  return sum;
}

double tool_energy_J(std::span<const contact::Contact> contacts) {
  double energy_J = 0.0;
  for (const contact::Contact& contact : contacts)
    if (contact.is_tool) energy_J += stored_J(contact);
  return energy_J;
}

EnergyFlow energy_flow(const bodies::World& before, const Trial& after,
                       std::span<const contact::Contact> contacts, double duration_s) {
  EnergyFlow sum;
  for (const bodies::BodyRange& body : before.bodies) {
    if (body.is_sleeping) continue;
    for (int i = 0; i < body.spring_count; ++i) {
      const bodies::Spring& spring =
          before.springs[static_cast<std::size_t>(body.first_spring + i)];
      const bodies::Node& a = after.nodes[static_cast<std::size_t>(spring.a)];
      const bodies::Node& b = after.nodes[static_cast<std::size_t>(spring.b)];
      const double lengthening_m_s =
          (b.position_m - a.position_m).stableNormalized().dot(b.velocity_m_s - a.velocity_m_s);
      sum.spring_damping_J +=
          duration_s * spring.damping_N_s_per_m * lengthening_m_s * lengthening_m_s;
    }
  }
  for (const bodies::Joint& joint : before.joints)
    sum += joint_flow(joint, before, after, duration_s);
  for (std::size_t i = 0; i < contacts.size(); ++i)
    sum += contact_flow(i, before, after, contacts, duration_s);
  sum.friction_J -= after.stretch_gain_J;
  return sum;
}

EnergyByHand_J tool_flow_J(const bodies::World& before, const Trial& after,
                           std::span<const contact::Contact> contacts, double duration_s) {
  std::size_t first = contacts.size();
  while (first > 0 && contacts[first - 1].is_tool) --first;
  EnergyByHand_J sum_J{};  // in the order of energy_flow(), to the bit
  for (std::size_t i = first; i < contacts.size(); ++i)
    sum_J += contact_flow(i, before, after, contacts, duration_s).tool_J;
  return sum_J;
}

EnergyByHand_J led_flow_J(const bodies::World& before, const Trial& after,
                          std::span<const contact::Contact> contacts, double duration_s) {
  EnergyByHand_J sum_J{};
  for (const contact::Contact& contact : contacts) {
    const auto [own, a, b] = sides_of(contact, before, after);
    sum_J[hand_of(contact)] += short_of_mean_N(own, a, b).dot(b.displacement_m);
    sum_J += contact_flow(own, a, b, duration_s, nullptr, nullptr).tool_J;
  }
  return sum_J;
}

EnergyByHand_J& operator+=(EnergyByHand_J& sum, const EnergyByHand_J& flow) {
  for (std::size_t hand = 0; hand < sum.size(); ++hand) sum[hand] += flow[hand];
  return sum;
}

EnergyFlow& operator+=(EnergyFlow& sum, const EnergyFlow& flow) {
  sum.spring_damping_J += flow.spring_damping_J;
  sum.contact_damping_J += flow.contact_damping_J;
  sum.friction_J += flow.friction_J;
  sum.unsolved_J += flow.unsolved_J;
  sum.given_J += flow.given_J;
  sum.tool_J += flow.tool_J;
  return sum;
}

Eigen::Vector3d momentum_kg_m_per_s(const bodies::World& world) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const bodies::Node& node : world.nodes)
    if (!node.pinned) sum += node.mass_kg * node.velocity_m_s;
  for (const bodies::RigidBody& body : world.rigid_bodies)
    if (body.free) sum += body.mass_kg * body.velocity_m_s;
  return sum;
}

Eigen::Vector3d angular_momentum_kg_m2_per_s(const bodies::World& world) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const bodies::Node& node : world.nodes)
    if (!node.pinned) sum += node.mass_kg * node.position_m.cross(node.velocity_m_s);
  for (const bodies::RigidBody& body : world.rigid_bodies) {
    if (!body.free) continue;
    const Eigen::Matrix3d r = body.orientation.toRotationMatrix();
    sum += body.mass_kg * body.position_m.cross(body.velocity_m_s) +
           r * body.inertia_kg_m2.cwiseProduct(r.transpose() * body.angular_velocity_rad_s);
  }
  return sum;
}

}  // namespace stillgrid::dynamics
