#pragma once

#include <Eigen/Core>

#include "shared/collision/contact_law.hpp"

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

/// What a contact does over a substep, on a.
struct ContactImpulse {
  Eigen::Vector3d impulse_N_s = Eigen::Vector3d::Zero();
  double spring_N = 0.0, damper_N = 0.0;                // along the normal, means
  Eigen::Vector3d stretch_m = Eigen::Vector3d::Zero();  // at its end
  double sticking = 1.0;  // 1: sticks; less: slides, and the force is that share of what would hold
};

/// How deep the contact is as the substep begins, and as it ends at that separation speed:
/// positions move at the old velocity for its first half and at the new one for its second.
[[nodiscard]] double start_depth_m(const SubstepContact& contact, double substep_s) noexcept;
[[nodiscard]] double end_depth_m(const SubstepContact& contact,
                                 const Eigen::Vector3d& end_velocity_m_s,
                                 double substep_s) noexcept;

/// Energy of a contact's spring, J.
[[nodiscard]] double spring_energy_J(const collision::ContactMaterial& material,
                                     double depth_m) noexcept;

/// What holds points of contact together across the normal.
struct StickingForce {
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
  Eigen::Vector3d stretch_m = Eigen::Vector3d::Zero();  // at the substep's end
  double share = 1.0;  // 1: sticks; less: slides, and the force is that share of what would hold
};
/// A spring of the contact's own stiffness with its own damper, stretched as the points slide, and
/// in line with them something that gives way at most_N [Cundall, Strack 1979]. Taken at the
/// substep's end, so that it never gives energy: with r what would hold and s the stretch, the loss
/// is h c |ds/h|^2 + k |ds|^2 / 2 + most_N |slip|, and the slip is along r.
[[nodiscard]] StickingForce sticking_force(const SubstepContact& contact,
                                           const Eigen::Vector3d& slid_m, double most_N,
                                           double substep_s) noexcept;

/// The mean of the contact law's force over the straight way from the substep's start to its end,
/// times the substep.
///
/// The spring's mean is (U(end) - U(start)) / way with U = k depth^2 / 2 where depth > 0: the work
/// of the impulse is the change of that energy, exactly, also where the contact comes or goes. The
/// approach damper acts over the part of the way in which the spheres overlap. At rest the force is
/// k depth.
///
/// Friction sticks by sticking_force().
[[nodiscard]] ContactImpulse contact_impulse(const SubstepContact& contact,
                                             const Eigen::Vector3d& end_velocity_m_s,
                                             double substep_s) noexcept;

/// How much impulse a change of the end velocity may ask for at most, N s per m/s; across the
/// normal while it sticks no more than it does.
struct ImpulseSlopes {
  double normal_kg = 0.0, across_kg = 0.0;
};
/// Pre: `at` is contact_impulse() of the same contact and substep.
[[nodiscard]] ImpulseSlopes impulse_slopes(const SubstepContact& contact, const ContactImpulse& at,
                                           double substep_s) noexcept;

/// The stretch carried along with a contact that turned: to the new normal by the shortest turn,
/// and about it by the angle, as long as before. Pre: both normals unit, stretch across `before`.
[[nodiscard]] Eigen::Vector3d carried_stretch_m(const Eigen::Vector3d& stretch_m,
                                                const Eigen::Vector3d& before,
                                                const Eigen::Vector3d& now,
                                                double turned_rad) noexcept;

}  // namespace stillgrid::dynamics
