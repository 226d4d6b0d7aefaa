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

/// How deep the contact is as the substep begins, and as it ends at that separation speed:
/// positions move at the old velocity for its first half and at the new one for its second.
[[nodiscard]] double start_depth_m(const SubstepContact& contact, double substep_s) noexcept;
[[nodiscard]] double end_depth_m(const SubstepContact& contact,
                                 const Eigen::Vector3d& end_velocity_m_s,
                                 double substep_s) noexcept;

/// Energy of a contact's spring, J.
[[nodiscard]] double spring_energy_J(const collision::ContactMaterial& material,
                                     double depth_m) noexcept;

/// How much impulse a change of the end velocity may ask for at most, N s per m/s; across the
/// normal while it sticks no more than it does.
struct ImpulseSlopes {
  double normal_kg = 0.0, across_kg = 0.0;
};

/// The stretch carried along with a contact that turned: to the new normal by the shortest turn,
/// and about it by the angle, as long as before. Pre: both normals unit, stretch across `before`.
[[nodiscard]] Eigen::Vector3d carried_stretch_m(const Eigen::Vector3d& stretch_m,
                                                const Eigen::Vector3d& before,
                                                const Eigen::Vector3d& now,
                                                double turned_rad) noexcept;

}  // namespace stillgrid::dynamics
