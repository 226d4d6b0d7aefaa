#include "sim_server/dynamics/contacts/substep_law.hpp"

#include <algorithm>

namespace stillgrid::dynamics {

double start_depth_m(const SubstepContact& contact, double substep_s) noexcept {
  return contact.depth_m + 0.5 * substep_s * contact.normal.dot(contact.start_velocity_m_s);
}

double end_depth_m(const SubstepContact& contact, const Eigen::Vector3d& end_velocity_m_s,
                   double substep_s) noexcept {
  return contact.depth_m - 0.5 * substep_s * contact.normal.dot(end_velocity_m_s);
}

double spring_energy_J(const collision::ContactMaterial& material, double depth_m) noexcept {
  const double pressed_m = std::max(0.0, depth_m);
  return 0.5 * material.stiffness_N_per_m * pressed_m * pressed_m;
}

Eigen::Vector3d carried_stretch_m(const Eigen::Vector3d& stretch_m, const Eigen::Vector3d& before,
                                  const Eigen::Vector3d& now, double turned_rad) noexcept {
  const double length_m = stretch_m.norm();
  if (!(length_m > 0.0)) return Eigen::Vector3d::Zero();
  Eigen::Vector3d carried_m = stretch_m + turned_rad * before.cross(stretch_m);
  // Opposite normals are no contact that turned.
  const double along = 1.0 + before.dot(now);
  if (along > 1e-3) carried_m -= now.dot(carried_m) / along * (before + now);
  carried_m -= now.dot(carried_m) * now;
  const double carried_length_m = carried_m.norm();
  return carried_length_m > 0.0 ? Eigen::Vector3d(length_m / carried_length_m * carried_m)
                                : Eigen::Vector3d::Zero();
}

}  // namespace stillgrid::dynamics
