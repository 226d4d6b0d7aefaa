#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "sim_server/contact/sticking.hpp"
#include "sim_server/dynamics/contacts/contact_movers.hpp"

namespace stillgrid::dynamics {

/// A contact in the middle of a substep, where its direction and its lever are taken for all of it.
struct SubstepContact {
  collision::ContactMaterial material;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // towards a
  double depth_m = 0.0;                               // in the middle; negative: a gap
  Eigen::Vector3d start_velocity_m_s =
      Eigen::Vector3d::Zero();  // of a's point of contact from b's, as the substep begins
  Eigen::Vector3d stretch_m = Eigen::Vector3d::Zero();  // what sticking has stored, across normal
  bool is_viscous = false;  // friction of the tool: by the slip, nothing sticks
};

/// How deep the contact is as the substep begins, and as it ends at that separation speed:
/// positions move at the old velocity for its first half and at the new one for its second.
inline double start_depth_m(const SubstepContact& contact, double substep_s) {
  return contact.depth_m + 0.5 * substep_s * contact.normal.dot(contact.start_velocity_m_s);
}

inline double end_depth_m(const SubstepContact& contact, const Eigen::Vector3d& end_velocity_m_s,
                          double substep_s) {
  return contact.depth_m - 0.5 * substep_s * contact.normal.dot(end_velocity_m_s);
}

/// Energy of a contact's spring, J.
inline double spring_energy_J(const collision::ContactMaterial& material, double depth_m) {
  const double pressed_m = std::max(0.0, depth_m);
  return 0.5 * material.stiffness_N_per_m * pressed_m * pressed_m;
}

/// The stretch carried along with a contact that turned: to the new normal by the shortest turn,
/// and about it by the angle, as long as before. Pre: both normals unit, stretch across `before`.
inline Eigen::Vector3d carried_stretch_m(const Eigen::Vector3d& stretch_m,
                                         const Eigen::Vector3d& before, const Eigen::Vector3d& now,
                                         double turned_rad) {
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

/// What a contact does over a substep, on a.
struct ContactImpulse {
  Eigen::Vector3d impulse_N_s = Eigen::Vector3d::Zero();
  double spring_N = 0.0, damper_N = 0.0;                // along the normal, means
  Eigen::Vector3d stretch_m = Eigen::Vector3d::Zero();  // at its end
  double sticking = 1.0;  // 1: sticks; less: slides, and the force is that share of what would hold
};

/// The mean of max(depth, 0) over a straight way.
inline double mean_depth_m(double start_m, double end_m) {
  if (start_m > 0.0 && end_m > 0.0) return 0.5 * (start_m + end_m);
  const double deepest_m = std::max(start_m, end_m);
  if (!(deepest_m > 0.0)) return 0.0;
  return 0.5 * deepest_m * deepest_m / (deepest_m - std::min(start_m, end_m));
}

/// One contact by the law of ContactRows, as it is written down.
inline ContactImpulse contact_impulse(const SubstepContact& contact,
                                      const Eigen::Vector3d& end_velocity_m_s, double substep_s) {
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
  const contact::StickingForce held =
      contact::sticking_force(material, contact.stretch_m, substep_s * slip_m_s, most_N, substep_s);
  result.sticking = held.share;
  result.stretch_m = held.stretch_m;
  result.impulse_N_s += substep_s * held.force_N;
  return result;
}

/// How much impulse a change of the end velocity may ask for at most, N s per m/s; across the
/// normal while it sticks no more than it does.
struct ImpulseSlopes {
  double normal_kg = 0.0, across_kg = 0.0;
};

/// How the impulse may change at most. Pre: `at` is contact_impulse() of the same contact and
/// substep.
inline ImpulseSlopes impulse_slopes(const SubstepContact& contact, const ContactImpulse& at,
                                    double substep_s) {
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

}  // namespace stillgrid::dynamics
