#include "shared/dynamics/field_contacts.hpp"

#include <algorithm>
#include <cmath>

#include "shared/dynamics/at.hpp"

namespace stillgrid::dynamics {
namespace {

void scale_stretch(RowPlace& place, std::size_t lane, float factor) {
  for (RowFloats& stretch : place.stretch_m) stretch[lane] *= factor;
}

}  // namespace

bool FieldContacts::stay_within(const ContactListing& listing, const SceneState& state,
                                double tick_s) const {
  const double falls_m = tick_s * tick_s * description_.gravity_m_s2.norm();
  for (std::size_t f = 0; f < poses_.size(); ++f) {
    const Description::Field& field = description_.fields[f];
    const FieldBase& base = listing.field_base()[f];
    const double path_m = field_motion_m(field, base.pose(), field_pose(field, state));
    if (!(path_m + tick_s * field_speed_m_s(field, state) + falls_m < base.position_m.w))
      return false;
  }
  return true;
}

void FieldContacts::adopt(const ContactListing& listing, ContactBodies& bodies) const {
  const std::size_t spheres = description_.spheres.size();
  const std::span<const FieldLane> lanes = listing.field_lanes();
  bodies.places.resize(spheres + lanes.size());
  bodies.arms.resize(spheres + lanes.size());
  for (std::size_t k = 0; k < lanes.size(); ++k)
    bodies.arms[spheres + k].radius_m =
        static_cast<float>(field_radius_m(description_.fields[at(lanes[k].field)]));
}

double FieldContacts::most_lengths(const ContactListing& listing, const SceneState& state,
                                   double tick_s, double least) const {
  double most = least;
  for (const FieldLane& lane : listing.field_lanes()) {
    const std::size_t s = at(listing.order()[at(lane.place)]),
                      r = at(description_.fields[at(lane.field)].rigid);
    const Description::Sphere& sphere = description_.spheres[s];
    const Description::Field& field = description_.fields[at(lane.field)];
    const double length_m = std::min(listing.lengths_m()[s], field_cell_m(field));
    const Eigen::Vector3d velocity_m_s = state.rigid_velocity_m_s[r].vector(),
                          turning_rad_s = state.angular_velocity_rad_s[r].vector(),
                          middle_m = state.rigid_position_m[r].vector();
    const Vector4& base = listing.base()[at(lane.place)];
    const double highest_m_s = highest_speed_m_s(sphere, state) + velocity_m_s.norm() +
                               turning_rad_s.norm() * ((base.vector() - middle_m).norm() + base.w);
    if (tick_s * highest_m_s <= most * length_m) continue;  // most are slow
    const Eigen::Vector3d centre_m = sphere_position_m(sphere, state).vector();
    const Eigen::Vector3d field_m_s = velocity_m_s + turning_rad_s.cross(centre_m - middle_m);
    const double path_m = tick_s * (sphere_velocity_m_s(sphere, state) - field_m_s).norm();
    const double lengths = path_m / length_m;
    if (lengths <= most) continue;
    const Eigen::Vector3d point_m = field_pose(field, state).into(centre_m);
    if (least_distance_m(field, point_m) < sphere.radius_m + path_m) most = lengths;
  }
  return most;
}

void FieldContacts::place(ContactListing& listing, const SceneState& state, ContactBodies& bodies,
                          double h) {
  const double falls_m = h * h * description_.gravity_m_s2.norm();
  for (std::size_t f = 0; f < poses_.size(); ++f) {
    const Description::Field& field = description_.fields[f];
    poses_[f] = {field_pose(field, state),
                 static_cast<float>(h * field_speed_m_s(field, state) + falls_m)};
  }
  std::size_t slot = description_.spheres.size();
  for (FieldLane& lane : listing.field_lanes()) {
    const Description::Field& field = description_.fields[at(lane.field)];
    const Pose& own = poses_[at(lane.field)];
    const float(&moved_m)[3] = bodies.places[at(lane.place)].moved_m;
    const Vector4 centre_m =
        listing.base()[at(lane.place)] + Vector4(moved_m[0], moved_m[1], moved_m[2]);
    const ToolLane* const tool =
        lane.tool_lane < 0 ? nullptr : &listing.tool_lanes()[at(lane.tool_lane)];
    TangentSphere tangent;
    Eigen::Vector3d apart_m;
    if (tool != nullptr && tool->is_held) {
      apart_m = centre_m.vector() - own.pose.out_of(tool->centre_m);
      tangent.stiffness_scale = tool->share * tool->map_scale;
    } else {
      tangent = tangent_sphere(field, own.pose, centre_m.vector(), lane.radius_m);
      apart_m = tangent_line_m(tangent, lane.radius_m + field_radius_m(field));
    }
    const Eigen::Vector3d rigid_m = state.rigid_position_m[at(field.rigid)].vector();
    set_vector(bodies.places[slot].moved_m,
               Vector4(moved_m[0], moved_m[1], moved_m[2]) - Vector4(apart_m));
    bodies.places[slot].margin_m = own.margin_m;
    set_vector(bodies.arms[slot].arm_m, Vector4(centre_m.vector() - apart_m - rigid_m));
    ++slot;
    RowPlace& place = listing.rows().places[lane.row];
    const auto scale = static_cast<float>(tangent.stiffness_scale);
    place.stiffness_N_per_m[lane.lane] = scale * lane.stiffness_N_per_m;
    place.damping_N_s_per_m[lane.lane] = scale * lane.damping_N_s_per_m;
    lane.stiffness_root = tool != nullptr ? 1.0F : static_cast<float>(stiffness_root(tangent));
    scale_stretch(place, lane.lane, 1.0F / lane.stiffness_root);
  }
}

double FieldContacts::energy_J(const ContactListing& listing, const SceneState& state,
                               int rigid) const {
  const auto is_driven = [&](int r) {
    return r >= 0 && description_.rigid_bodies[at(r)].is_driven;
  };
  double sum_J = 0.0;
  for (const FieldLane& lane : listing.field_lanes()) {
    const Description::Field& field = description_.fields[at(lane.field)];
    const Description::Sphere& sphere = description_.spheres[at(listing.order()[at(lane.place)])];
    if (rigid >= 0 && sphere.rigid != rigid && field.rigid != rigid) continue;
    if (is_driven(sphere.rigid) && is_driven(field.rigid)) continue;  // no energy of the scene
    const ToolLane* const tool =
        lane.tool_lane < 0 ? nullptr : &listing.tool_lanes()[at(lane.tool_lane)];
    TangentSphere tangent;
    if (tool != nullptr && tool->is_held) {
      tangent.depth_m = listing.tool_depth_m(*tool, state);
      tangent.map_scale = tool->share * tool->map_scale;
    } else {
      tangent = tangent_sphere(field, field_pose(field, state),
                               sphere_position_m(sphere, state).vector(), sphere.radius_m);
    }
    const double depth_m = std::max(0.0, tangent.depth_m);
    double square = tangent.map_scale * depth_m * depth_m;
    for (const RowFloats& stretch : listing.rows().places[lane.row].stretch_m)
      square += double{stretch[lane.lane]} * double{stretch[lane.lane]};
    sum_J += 0.5 * double{lane.stiffness_N_per_m} * square;
  }
  return sum_J;
}

void FieldContacts::finish(ContactListing& listing) {
  for (const FieldLane& lane : listing.field_lanes())
    scale_stretch(listing.rows().places[lane.row], lane.lane, lane.stiffness_root);
}

}  // namespace stillgrid::dynamics
