#include "sim_server/contact/field_crossing.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "sim_server/contact/field_touch.hpp"

namespace stillgrid::contact {
namespace {

constexpr double kGraze = 0.01;   // of the radius: no meeting
constexpr double kFinest = 0.5;   // of a fine cell and the radius: no way as short passes through
constexpr double kDeepest = 0.5;  // of the depth that a way leads to, by which one step may deepen
constexpr int kMaxLooks = 256;    // at a way
constexpr int kBisections = 12;

/// A contact's field, and the sphere that it meets.
struct Sides {
  const bodies::FieldBody* field;
  int sphere;  // its number, or -1: what is given in the contact
  double radius_m;
};

Sides sides_of(const Contact& contact, const Ways& ways) {
  const bool is_first = bodies::is_field(*ways.world, contact.a);
  return {&bodies::field_of(*ways.world, is_first ? contact.a : contact.b),
          is_first ? -1 : contact.a, is_first ? contact.radius_b_m : contact.radius_a_m};
}

/// How far a prescribed body has gone from where it starts when this share is over.
Eigen::Vector3d led_m(const bodies::RigidBody& body, const Ways& ways, double share) {
  const double time_s = ways.world->time_s;
  return bodies::prescribed_state(body, time_s + share * ways.duration_s).position_m -
         bodies::prescribed_state(body, time_s).position_m;
}

FieldPose pose_at(const bodies::FieldBody& field, const Ways& ways, double share) {
  FieldPose pose = pose_of(field, ways.world->rigid_bodies);
  if (field.rigid < 0 || share == 0.0) return pose;
  const auto rigid = static_cast<std::size_t>(field.rigid);
  const bodies::RigidBody &start = ways.world->rigid_bodies[rigid], &end = ways.end_bodies[rigid];
  if (!start.free && share < 1.0) {
    pose.position_m += led_m(start, ways, share);
    return pose;
  }
  pose.position_m += share * (end.position_m - start.position_m);
  pose.rotation = start.orientation.slerp(share, end.orientation).toRotationMatrix();
  return pose;
}

/// Where the sphere is then, seen from the field's body.
Eigen::Vector3d place_m(const Contact& contact, const Sides& sides, const Ways& ways,
                        double share) {
  const FieldPose pose = pose_at(*sides.field, ways, share);
  if (sides.sphere < 0) return pose.into(kinematic_position_m(contact, share));
  const auto i = static_cast<std::size_t>(sides.sphere);
  const Eigen::Vector3d &from_m = ways.start[i].position_m, &to_m = ways.end[i].position_m;
  if (const int rigid = ways.world->spheres[i].rigid; rigid >= 0 && share < 1.0) {
    const bodies::RigidBody& body = ways.world->rigid_bodies[static_cast<std::size_t>(rigid)];
    if (!body.free) return pose.into(from_m + led_m(body, ways, share));
  }
  return pose.into(from_m + share * (to_m - from_m));
}

/// Of a way that turns back, longer than its chord, the middle tells.
template <class Way>
double length_of(const Way& way_m) {
  const Eigen::Vector3d from_m = way_m(0.0);
  return std::max((way_m(1.0) - from_m).norm(), 2.0 * (way_m(0.5) - from_m).norm());
}

/// No way as short as this passes through.
double finest_of(const Sides& sides) {
  return kFinest * (cell_m(*sides.field) + sides.radius_m);
}

}  // namespace

FieldPassage passage_of(const Contact& contact, const Ways& ways) noexcept {
  const Sides sides = sides_of(contact, ways);
  const bodies::FieldBody& field = *sides.field;
  const double radius_m = sides.radius_m;
  const auto way_m = [&](double share) { return place_m(contact, sides, ways, share); };
  const double finest_m = finest_of(sides);
  const auto depth_m = [&](double share) { return -gap_m(field, way_m(share), radius_m); };
  const Eigen::Vector3d from_m = way_m(0.0), to_m = way_m(1.0);
  FieldPassage passage;
  const double start_m = depth_m(0.0), end_m = depth_m(1.0);
  passage.deepest_m = std::max(start_m, end_m);
  const double length_m = length_of(way_m);
  // Written so that NaN is no crossing.
  if (!(length_m > finest_m)) return passage;
  double deepest_share = start_m > end_m ? 0.0 : 1.0, share = 0.0, now_m = start_m;
  for (int looks = 0; looks < kMaxLooks; ++looks) {
    share += std::max(finest_m, -now_m) / length_m;
    if (!(share < 1.0)) break;
    now_m = depth_m(share);
    if (!(now_m > passage.deepest_m)) continue;
    passage.deepest_m = now_m;
    deepest_share = share;
  }
  const double before_m = std::max(start_m, 0.0);
  if (!(deepest_share > 0.0 && deepest_share < 1.0) ||
      !(passage.deepest_m > before_m + kGraze * radius_m))
    return passage;
  // Sliding over a curve is no passage.
  const bool is_seen = start_m > 0.0 || end_m > 0.0;
  if (is_seen && passage.deepest_m - before_m <= finest_m) return passage;
  const FieldTouch end = touch_of(field, {}, to_m, radius_m);
  passage.passes = !(end.depth_m > 0.0 && end.normal.dot(to_m - from_m) < 0.0);
  if (!passage.passes) return passage;
  // By bisection: depth grows up to the deepest.
  const double stop_m = before_m + kDeepest * (passage.deepest_m - before_m);
  double low = 0.0;
  passage.stop = deepest_share;
  for (int looks = 0; looks < kBisections; ++looks) {
    const double middle = 0.5 * (low + passage.stop);
    (depth_m(middle) < stop_m ? low : passage.stop) = middle;
  }
  return passage;
}

double share_before_field(const Contact& contact, const Ways& ways) noexcept {
  const Sides sides = sides_of(contact, ways);
  const auto way_m = [&](double share) { return place_m(contact, sides, ways, share); };
  if (!(length_of(way_m) > finest_of(sides))) return 1.0;
  const FieldPassage passage = passage_of(contact, ways);
  return passage.passes ? passage.stop : 1.0;
}

bool meets_field(const Contact& contact, const Ways& ways) noexcept {
  return passage_of(contact, ways).deepest_m > 0.0;
}

}  // namespace stillgrid::contact
