#include "sim_server/bodies/world.hpp"

#include <algorithm>

#include "sim_server/bodies/joints.hpp"

namespace stillgrid::bodies {

PrescribedState prescribed_state(const RigidBody& body, double time_s) {
  return {body.prescribed.position_m(time_s), body.prescribed.velocity_at_m_s(time_s)};
}

double kinetic_energy_J(const RigidBody& body) {
  const Eigen::Vector3d spin_rad_s = body.orientation.conjugate() * body.angular_velocity_rad_s;
  return 0.5 * body.mass_kg * body.velocity_m_s.squaredNorm() +
         0.5 * spin_rad_s.cwiseAbs2().dot(body.inertia_kg_m2);
}

double spring_energy_J(const Spring& spring, const Node& a, const Node& b) {
  const double stretch_m = (b.position_m - a.position_m).norm() - spring.rest_length_m;
  return 0.5 * spring.stiffness_N_per_m * stretch_m * stretch_m;
}

double mechanical_energy_J(const World& world) {
  double energy_J = 0.0;
  for (const Node& node : world.nodes)
    if (!node.pinned)
      energy_J += node.mass_kg *
                  (0.5 * node.velocity_m_s.squaredNorm() - world.gravity_m_s2.dot(node.position_m));
  for (const RigidBody& body : world.rigid_bodies)
    if (body.free)
      energy_J += kinetic_energy_J(body) - body.mass_kg * world.gravity_m_s2.dot(body.position_m);
  for (const Spring& spring : world.springs)
    energy_J += spring_energy_J(spring, world.nodes[static_cast<std::size_t>(spring.a)],
                                world.nodes[static_cast<std::size_t>(spring.b)]);
  for (const Joint& joint : world.joints)
    energy_J += joint_energy_J(joint, world.nodes, world.rigid_bodies);
  return energy_J;
}

}  // namespace stillgrid::bodies
