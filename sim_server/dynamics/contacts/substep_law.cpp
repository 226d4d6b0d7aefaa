#include "sim_server/dynamics/contacts/substep_law.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid::dynamics {
namespace {

/// The mean of max(depth, 0) over a straight way.
double mean_depth_m(double start_m, double end_m) noexcept {
  if (start_m > 0.0 && end_m > 0.0) return 0.5 * (start_m + end_m);
  const double deepest_m = std::max(start_m, end_m);
  if (!(deepest_m > 0.0)) return 0.0;
  return 0.5 * deepest_m * deepest_m / (deepest_m - std::min(start_m, end_m));
}

}  // namespace

StickingForce sticking_force(const SubstepContact& contact, const Eigen::Vector3d& slid_m,
                             double most_N, double substep_s) noexcept {
  const double damper_N_per_m = contact.material.damping_N_s_per_m / substep_s;
  const double both_N_per_m = contact.material.stiffness_N_per_m + damper_N_per_m;
  if (!(both_N_per_m > 0.0)) return {};
  const Eigen::Vector3d damped_N = damper_N_per_m * contact.stretch_m;
  const Eigen::Vector3d holding_N = both_N_per_m * (contact.stretch_m + slid_m) - damped_N;
  const double squared_N2 = holding_N.squaredNorm();
  StickingForce result;
  if (squared_N2 > most_N * most_N) result.share = most_N / std::sqrt(squared_N2);
  result.force_N = -result.share * holding_N;
  result.stretch_m = (damped_N - result.force_N) / both_N_per_m;
  return result;
}

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

ContactImpulse contact_impulse(const SubstepContact& contact,
                               const Eigen::Vector3d& end_velocity_m_s, double substep_s) noexcept {
  ContactImpulse result;
  const collision::ContactMaterial& material = contact.material;
  const double start_m = start_depth_m(contact, substep_s);
  const double end_m = end_depth_m(contact, end_velocity_m_s, substep_s);
  if (!(std::max(start_m, end_m) > 0.0)) return result;
  result.spring_N = material.stiffness_N_per_m * mean_depth_m(start_m, end_m);
  result.damper_N = material.damping_N_s_per_m *
                    std::max(0.0, std::max(end_m, 0.0) - std::max(start_m, 0.0)) / substep_s;
  const double normal_N = result.spring_N + result.damper_N;
  result.impulse_N_s = substep_s * normal_N * contact.normal;
  if (!(material.friction > 0.0)) return result;

  Eigen::Vector3d slip_m_s = 0.5 * (contact.start_velocity_m_s + end_velocity_m_s);
  slip_m_s -= contact.normal.dot(slip_m_s) * contact.normal;
  const double most_N = material.friction * normal_N;
  if (contact.is_viscous) {
    const double speed_m_s = slip_m_s.norm();
    result.sticking = material.slip_speed_m_s / std::max(speed_m_s, material.slip_speed_m_s);
    result.impulse_N_s -= substep_s * most_N / material.slip_speed_m_s * result.sticking * slip_m_s;
    return result;
  }
  const StickingForce held = sticking_force(contact, substep_s * slip_m_s, most_N, substep_s);
  result.sticking = held.share;
  result.stretch_m = held.stretch_m;
  result.impulse_N_s += substep_s * held.force_N;
  return result;
}

ImpulseSlopes impulse_slopes(const SubstepContact& contact, const ContactImpulse& at,
                             double substep_s) noexcept {
  const collision::ContactMaterial& material = contact.material;
  const double spring_kg = 0.25 * substep_s * substep_s * material.stiffness_N_per_m;
  ImpulseSlopes slopes{.normal_kg = spring_kg + 0.5 * substep_s * material.damping_N_s_per_m};
  if (!(material.friction > 0.0)) return slopes;
  // A chord to the origin bounds a force that only flattens.
  const double held = at.sticking;
  const double damper_kg = 0.5 * substep_s * material.damping_N_s_per_m;
  slopes.across_kg = contact.is_viscous ? 0.5 * substep_s * held * material.friction *
                                              (at.spring_N + at.damper_N) / material.slip_speed_m_s
                                        : held * (2.0 * spring_kg + damper_kg);
  return slopes;
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
