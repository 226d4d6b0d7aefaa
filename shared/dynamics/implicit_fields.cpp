// Contacts with distance fields in an implicit step.
#include <algorithm>
#include <cmath>

#include "shared/dynamics/at.hpp"
#include "shared/dynamics/implicit_contacts.hpp"

namespace stillgrid::dynamics {
void ImplicitContacts::set_field(const ContactListing& listing, std::int32_t sphere_b, Touch& touch,
                                 Coupling& coupling) const {
  const FieldLane& lane = listing.field_lanes()[at(sphere_b) - description_.spheres.size()];
  const Description::Field& field = description_.fields[at(lane.field)];
  touch.field = lane.field;
  touch.radius_b_m = field_radius_m(field);
  touch.stiffness_N_per_m = double{lane.stiffness_N_per_m};
  touch.damping_N_s_per_m = double{lane.damping_N_s_per_m};
  coupling.b.rigid = field.rigid;
}

/// From the other side's centre to side a's at the start.
Eigen::Vector3d ImplicitContacts::start_line_m(const Touch& touch) const {
  const Eigen::Vector3d& a = before_m_[at(touch.sphere_a)];
  if (touch.is_held) return a - field_before_[at(touch.field)].out_of(touch.held_centre_m);
  if (touch.field >= 0) {
    const auto f = at(touch.field);
    return tangent_line_m(
        tangent_sphere(description_.fields[f], field_before_[f], a, touch.radius_a_m),
        touch.radius_a_m + touch.radius_b_m);
  }
  if (touch.sphere_b >= 0) return a - before_m_[at(touch.sphere_b)] + touch.shift_m;
  return (touch.normal.dot(a) - touch.offset_m) * touch.normal;
}

/// From the centre of the field's body to the sphere's centre.
Eigen::Vector3d ImplicitContacts::field_arm_m(const Touch& touch, const ImplicitPoses& poses,
                                              Moment moment) const {
  const std::size_t a = at(touch.sphere_a), r = at(description_.fields[at(touch.field)].rigid);
  if (moment == Moment::kEnd) return after_m_[a] - poses.to().rigid_position_m[r].vector();
  const Vector4 both_m = poses.from().rigid_position_m[r] + poses.to().rigid_position_m[r];
  return 0.5 * (before_m_[a] + after_m_[a] - both_m.vector());
}

}  // namespace stillgrid::dynamics
