#include "sim_server/bodies/world.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim_server/bodies/joints.hpp"

namespace stillgrid::bodies {

void number_unknowns(World& world) {
  world.unknown_count = 0;
  const auto take = [&](bool moves, int count) {
    if (!moves) return kNoUnknown;
    const int first = world.unknown_count;
    world.unknown_count += count;
    return first;
  };
  for (const BodyRange& body : world.bodies) {
    for (int i = 0; i < body.node_count; ++i) {
      Node& node = world.nodes[static_cast<std::size_t>(body.first_node + i)];
      node.unknown = take(!node.pinned && !body.is_sleeping, 3);
    }
    if (body.rigid < 0) continue;
    RigidBody& rigid = world.rigid_bodies[static_cast<std::size_t>(body.rigid)];
    rigid.unknown = take(rigid.free && !body.is_sleeping, 6);
  }
}

PrescribedState prescribed_state(const RigidBody& body, double time_s) {
  const PrescribedMotion& motion = body.prescribed;
  const double rate_rad_s = 2.0 * std::numbers::pi * motion.frequency_hz;
  const double speed_m_s = motion.amplitude_m * rate_rad_s * std::cos(rate_rad_s * time_s);
  return {motion.position_m(time_s), motion.velocity_m_s + speed_m_s * motion.direction};
}

PrescribedRange prescribed_range(const RigidBody& body, double from_s, double to_s) {
  const PrescribedMotion& motion = body.prescribed;
  if (!swings(body)) return {Eigen::Vector3d::Zero(), (to_s - from_s) * motion.velocity_m_s};
  const double rate_rad_s = 2.0 * std::numbers::pi * motion.frequency_hz;
  const double from = std::sin(rate_rad_s * from_s), to = std::sin(rate_rad_s * to_s);
  double least = std::min(from, to), most = std::max(from, to);
  // Turning points, counted in half periods from the first.
  const auto turns = [&](double time_s) { return 2.0 * motion.frequency_hz * time_s - 0.5; };
  const double first = std::ceil(turns(from_s)), last = std::floor(turns(to_s));
  for (double turn = first; turn <= std::min(last, first + 1.0); ++turn) {
    const double at = std::fmod(turn, 2.0) == 0.0 ? 1.0 : -1.0;
    least = std::min(least, at);
    most = std::max(most, at);
  }
  return {motion.amplitude_m * (least - from) * motion.direction,
          motion.amplitude_m * (most - from) * motion.direction};
}

bool is_moved(const RigidBody& body) {
  return !body.prescribed.velocity_m_s.isZero(0.0) || swings(body);
}

bool swings(const RigidBody& body) {
  return body.prescribed.amplitude_m * body.prescribed.frequency_hz != 0.0;
}

Eigen::Matrix3d world_inertia_kg_m2(const RigidBody& body) {
  const Eigen::Matrix3d r = body.orientation.toRotationMatrix();
  return r * body.inertia_kg_m2.asDiagonal() * r.transpose();
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
