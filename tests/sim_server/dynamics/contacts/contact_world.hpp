#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <random>
#include <vector>

#include "sim_server/dynamics/contacts/contact_core.hpp"
#include "tests/sim_server/dynamics/contacts/scalar_law.hpp"

namespace stillgrid::dynamics {

/// Rigid spheres of one material over a floor, or in a trough of planes, through the origin, moved
/// by the contact core alone: half a drift, a kick, half a drift. Contacts are all pairs that are
/// near, listed anew each substep.
struct ContactWorld {
  bodies::World world;
  ExplicitState state;
  std::vector<contact::Contact> contacts;
  ContactCore core;
  EnergyFlow flow;
  collision::ContactMaterial material;
  std::vector<Eigen::Vector3d> planes{Eigen::Vector3d::UnitZ()};  // their normals
  std::mt19937 random{1};
  bool shuffles = false, keeps = true;

  explicit ContactWorld(const collision::ContactMaterial& of, ContactAccuracy accuracy = {})
      : core(accuracy), material(of) {
    world.gravity_m_s2 = {0.0, 0.0, -9.81};
  }

  int add(const Eigen::Vector3d& position_m, double radius_m, double mass_kg,
          const Eigen::Vector3d& velocity_m_s = Eigen::Vector3d::Zero()) {
    bodies::SphereBinding& sphere = world.spheres.emplace_back();
    sphere.radius_m = radius_m;
    sphere.rigid = static_cast<int>(state.rigid.size());
    world.rigid_bodies.emplace_back().unknown = 6 * sphere.rigid;
    RigidState& body = state.rigid.emplace_back();
    body.position_m = position_m;
    body.velocity_m_s = velocity_m_s;
    body.inverse_mass_per_kg = 1.0 / mass_kg;
    body.inverse_inertia_per_kg_m2 =
        2.5 / (mass_kg * radius_m * radius_m) * Eigen::Matrix3d::Identity();
    body.free = true;
    return sphere.rigid;
  }

  void find(double near_m) {
    contacts.clear();
    // A sweep along x: who is near there.
    std::vector<std::size_t> order(state.rigid.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    const auto low = [&](std::size_t i) {
      return state.rigid[i].position_m.x() - world.spheres[i].radius_m;
    };
    std::sort(order.begin(), order.end(),
              [&](std::size_t i, std::size_t j) { return low(i) < low(j); });
    for (std::size_t first = 0; first < order.size(); ++first) {
      const std::size_t i = order[first];
      for (std::size_t next = first + 1; next < order.size(); ++next) {
        const std::size_t j = order[next];
        if (low(j) > low(i) + 2.0 * world.spheres[i].radius_m + near_m) break;
        const double within_m = world.spheres[i].radius_m + world.spheres[j].radius_m + near_m;
        const Eigen::Vector3d line_m = state.rigid[i].position_m - state.rigid[j].position_m;
        if (line_m.squaredNorm() > within_m * within_m) continue;
        contact::Contact& contact = contacts.emplace_back();
        contact.a = static_cast<int>(i);
        contact.b = static_cast<int>(j);
        contact.radius_a_m = world.spheres[i].radius_m;
        contact.radius_b_m = world.spheres[j].radius_m;
        contact.material = material;
      }
      for (std::size_t plane = 0; plane < planes.size(); ++plane) {
        const double height_m = planes[plane].dot(state.rigid[i].position_m);
        if (height_m > world.spheres[i].radius_m + near_m) continue;
        contact::Contact& contact = contacts.emplace_back();
        contact.a = static_cast<int>(i);
        contact.other = static_cast<int>(plane);
        contact.radius_a_m = world.spheres[i].radius_m;
        contact.material = material;
        contact.is_plane = true;
        contact.plane_normal = planes[plane];
      }
    }
    if (shuffles) {
      std::shuffle(contacts.begin(), contacts.end(), random);
      for (contact::Contact& contact : contacts)
        if (contact.b >= 0 && random() % 2 == 0) {
          std::swap(contact.a, contact.b);
          std::swap(contact.radius_a_m, contact.radius_b_m);
        }
    }
  }

  ContactSolve substep(double substep_s) {
    drift(0.5 * substep_s);
    core.take(world, contacts);
    core.begin(0.0, substep_s, substep_s, world.gravity_m_s2, state);
    for (RigidState& body : state.rigid) {
      body.velocity_m_s += substep_s * world.gravity_m_s2;
      body.spin_rad_s = body.inverse_inertia_per_kg_m2 * body.angular_momentum_N_m_s;
    }
    const ContactSolve solve = core.solve(substep_s, {}, state, flow);
    if (keeps) core.keep();
    drift(0.5 * substep_s);
    return solve;
  }

  void drift(double drift_s) {
    for (RigidState& body : state.rigid) body.position_m += drift_s * body.velocity_m_s;
  }

  [[nodiscard]] double kinetic_J() const {
    double energy_J = 0.0;
    for (const RigidState& body : state.rigid)
      energy_J += 0.5 * body.velocity_m_s.squaredNorm() / body.inverse_mass_per_kg +
                  0.5 * body.spin_rad_s.dot(body.angular_momentum_N_m_s);
    return energy_J;
  }
  [[nodiscard]] double gravity_J() const {
    double energy_J = 0.0;
    for (const RigidState& body : state.rigid)
      energy_J -= world.gravity_m_s2.dot(body.position_m) / body.inverse_mass_per_kg;
    return energy_J;
  }
  /// Of all overlaps, where the spheres are.
  [[nodiscard]] double overlaps_J() {
    find(0.0);
    double energy_J = 0.0;
    for (const contact::Contact& contact : contacts) {
      const Eigen::Vector3d& a_m = state.rigid[static_cast<std::size_t>(contact.a)].position_m;
      const double depth_m =
          contact.is_plane
              ? contact.radius_a_m - contact.plane_normal.dot(a_m)
              : contact.radius_a_m + contact.radius_b_m -
                    (a_m - state.rigid[static_cast<std::size_t>(contact.b)].position_m).norm();
      energy_J += spring_energy_J(material, depth_m);
    }
    return energy_J;
  }
  [[nodiscard]] double fastest_m_s() const {
    double most = 0.0;
    for (const RigidState& body : state.rigid) most = std::max(most, body.velocity_m_s.norm());
    return most;
  }
};

}  // namespace stillgrid::dynamics
