// Contacts of spheres with distance fields.
#include <algorithm>

#include "shared/dynamics/at.hpp"
#include "shared/dynamics/contact_listing.hpp"
#include "shared/dynamics/field_geometry.hpp"

namespace stillgrid::dynamics {
/// Fields stand behind spheres.
void ContactListing::collect_near_fields() {
  auto number = static_cast<std::int32_t>(description_.field_number(0));
  for (const Description::Field& field : description_.fields)
    near_spheres_.push_back({.rigid = field.rigid,
                             .body = field.body,
                             .mover = mover_of_rigid_[at(field.rigid)],
                             .kind = SideKind::kRigid,
                             .is_driven = description_.rigid_bodies[at(field.rigid)].is_driven,
                             .is_still = is_still(number++),
                             .material = field.material,
                             .is_tool = false,
                             .tool_slip_speed_m_s = 0.0F,
                             .is_field_point = false,
                             .radius_m = field_radius_m(field)});
}

bool ContactListing::may_meet_field(std::int32_t place, std::int32_t field) const {
  const NearSphere& sphere = near_spheres_[at(place)];
  const NearSphere& own = near_spheres_[description_.spheres.size() + at(field)];
  return sphere.rigid != own.rigid && sphere.body != own.body &&
         !(sphere.is_driven && own.is_driven && !sphere.is_tool) &&
         !std::ranges::binary_search(
             description_.apart,
             std::pair(std::min(sphere.body, own.body), std::max(sphere.body, own.body)));
}

/// How far a field may move until contacts are listed anew.
void ContactListing::bound_field_ways(const SceneState& state, double tick_s) {
  const double falls_m = description_.gravity_m_s2.norm() * tick_s * tick_s;
  field_base_.clear();
  for (const Description::Field& field : description_.fields) {
    const double next_m = tick_s * field_speed_m_s(field, state);
    field_base_.push_back(FieldBase::of(field_pose(field, state),
                                        listing_margin_m(field_cell_m(field), next_m) + falls_m));
  }
}

void ContactListing::gather_fields(const SceneState& state) {
  const auto fields = static_cast<std::int32_t>(description_.fields.size());
  for (std::int32_t f = 0; f < fields; ++f) {
    const Description::Field& field = description_.fields[at(f)];
    if (state.is_here[at(field.rigid)] == 0) continue;
    const FieldPose pose = field_base_[at(f)].pose();
    const double margin_m = field_base_[at(f)].position_m.w;
    Vector4 ball(pose.position_m + pose.axes * field_centre_m(field));
    ball.w = field_radius_m(field) + margin_m;
    near_field_.clear();
    pairs_.append_near(ball, near_field_);
    const bool is_field_still = near_spheres_[description_.spheres.size() + at(f)].is_still;
    for (const std::int32_t place : near_field_) {
      if (is_field_still && near_spheres_[at(place)].is_still) continue;
      const Vector4& base = base_[at(place)];
      const double within_m = near_spheres_[at(place)].radius_m + base.w;
      const double far_m = within_m + ball.w;
      if (!may_meet_field(place, f) || (base - ball).vector().squaredNorm() > far_m * far_m ||
          least_distance_m(field, pose.into(base.vector())) > within_m + margin_m)
        continue;
      if (add_fixture(place, static_cast<std::int32_t>(description_.spheres.size()) + f)) continue;
      add_candidate(place, static_cast<std::int32_t>(description_.spheres.size()) + f,
                    SideKind::kRigid);
    }
  }
}

/// Pre: all of the lane but its geometry is set for the sphere and the field.
void ContactListing::add_field_lane(std::size_t row, std::size_t lane) {
  RowPlace& place = rows_.places[row];
  const auto spheres = static_cast<std::int32_t>(description_.spheres.size());
  const auto slot = static_cast<std::int32_t>(field_lanes_.size());
  field_lanes_.push_back({.row = row,
                          .lane = lane,
                          .place = place.sphere_a[lane],
                          .field = place.sphere_b[lane] - spheres,
                          .radius_m = near_spheres_[at(place.sphere_a[lane])].radius_m,
                          .stiffness_N_per_m = place.stiffness_N_per_m[lane],
                          .damping_N_s_per_m = place.damping_N_s_per_m[lane]});
  place.sphere_b[lane] = spheres + slot;
}

std::int32_t ContactListing::listed_other(std::int32_t sphere_b) const {
  const auto spheres = static_cast<std::int32_t>(description_.spheres.size());
  return sphere_b < spheres ? sphere_b : spheres + field_lanes_[at(sphere_b - spheres)].field;
}

}  // namespace stillgrid::dynamics
