#include "sim_server/dynamics/step/energy_account.hpp"

#include "sim_server/bodies/joints.hpp"

namespace stillgrid::dynamics {
namespace {

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

}  // namespace

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
  sum.proxies_J += flow.proxies_J;
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
