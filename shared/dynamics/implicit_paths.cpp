// Paths of spheres in an implicit step, and what they would pass through.
#include <algorithm>
#include <cmath>

#include "shared/dynamics/at.hpp"
#include "shared/dynamics/implicit_contacts.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr double kPassed = 0.01;  // of the smaller radius: deeper on the path than at both ends
constexpr double kLongestPath = 0.25;  // of the smaller radius: shorter ones are not divided

}  // namespace

bool ImplicitContacts::any_passes() const {
  return std::ranges::any_of(touches_, [&](const Touch& touch) { return passes(touch); });
}

bool ImplicitContacts::passes(const Touch& touch) const {
  if (touch.field >= 0 && !touch.is_held) return passes_field(touch);
  if (touch.sphere_b < 0) return false;  // what is inside a plane is pushed out, however deep
  const Line line = line_of(touch);
  const Eigen::Vector3d way = line.line_m - touch.line_m;
  const double square = way.squaredNorm();
  const double smaller_m = std::min(touch.radius_a_m, touch.radius_b_m);
  const double share = -touch.line_m.dot(way);
  if (share <= 0.0 || share >= square) return false;
  if (square <= kLongestPath * kLongestPath * smaller_m * smaller_m) return false;
  const double nearest = (touch.line_m + share / square * way).norm();
  const double radii = touch.radius_a_m + touch.radius_b_m;
  return std::min({radii, line.before_m, line.after_m}) - nearest > kPassed * smaller_m;
}

bool ImplicitContacts::all_within(const ContactListing& listing) const {
  for (std::size_t place = 0; place < listing.order().size(); ++place) {
    const std::size_t s = at(listing.order()[place]);
    const Vector4& base = listing.base()[place];
    if ((after_m_[s] - base.vector()).squaredNorm() > base.w * base.w) return false;
  }
  for (std::size_t f = 0; f < field_after_.size(); ++f) {
    const FieldBase& base = listing.field_base()[f];
    if (field_motion_m(description_.fields[f], base.pose(), field_after_[f]) > base.position_m.w)
      return false;
  }
  return true;
}

/// Looks at places on the way of the sphere in the field's frame, half a cell apart.
bool ImplicitContacts::passes_field(const Touch& touch) const {
  constexpr double kMaxPlaces = 64.0;
  const auto f = at(touch.field), a = at(touch.sphere_a);
  const Description::Field& field = description_.fields[f];
  const Eigen::Vector3d from_m = field_before_[f].into(before_m_[a]);
  const Eigen::Vector3d way_m = field_after_[f].into(after_m_[a]) - from_m;
  const double cell_m = field_cell_m(field), length_m = way_m.norm();
  const double deep_m = 0.5 * std::max(cell_m, touch.radius_a_m);
  if (!(length_m > deep_m)) return false;
  const auto depth_m = [&](double share) {
    return tangent_sphere(field, FieldPose(), from_m + share * way_m, touch.radius_a_m).depth_m;
  };
  const double ends_m = std::max({0.0, depth_m(0.0), depth_m(1.0)});
  const double places = std::min(kMaxPlaces, std::ceil(2.0 * length_m / cell_m));
  for (double k = 1.0; k < places; k += 1.0)
    if (depth_m(k / places) > ends_m + deep_m) return true;
  return false;
}

}  // namespace stillgrid::dynamics
