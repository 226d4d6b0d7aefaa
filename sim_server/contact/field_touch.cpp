#include "sim_server/contact/field_touch.hpp"

#include <optional>

#include "shared/collision/distance_field.hpp"

namespace stillgrid::contact {
namespace {

Eigen::Array3d array(const std::array<float, 3>& v) {
  return Eigen::Map<const Eigen::Array3f>(v.data()).cast<double>();
}

/// How far a point is off the bricks, in which the solid lies.
double off_bricks_m(const proto::FieldShape& shape, const Eigen::Vector3d& point_m) {
  const Eigen::Array3d low_m = array(shape.lowest_m);
  const Eigen::Array3d high_m =
      low_m +
      double{shape.brick_m} *
          Eigen::Map<const Eigen::Array<std::uint32_t, 3, 1>>(shape.bricks.data()).cast<double>();
  const Eigen::Array3d at_m = point_m.array();
  return (at_m - at_m.max(low_m).min(high_m)).matrix().norm();
}

}  // namespace

FieldPose pose_of(const bodies::FieldBody& field, std::span<const bodies::RigidBody> rigid_bodies) {
  if (field.rigid < 0) return {field.position_m, field.orientation.toRotationMatrix()};
  const bodies::RigidBody& body = rigid_bodies[static_cast<std::size_t>(field.rigid)];
  return {body.position_m, body.orientation.toRotationMatrix()};
}

FieldTouch touch_of(const bodies::FieldBody& field, const FieldPose& pose,
                    const Eigen::Vector3d& centre_m, double radius_m) noexcept {
  const Eigen::Vector3d at_m = pose.into(centre_m);
  const proto::FieldShape& shape = field.field->shape();
  FieldTouch touch;
  if (const auto own = collision::field_contact(field.field->view(), at_m, radius_m)) {
    touch.depth_m = own->depth_m;
    touch.normal = pose.rotation * own->normal;
    touch.stiffness_scale = own->stiffness_scale;
    touch.map_scale = own->map_scale;
  } else {
    // Off the bricks, or where a solid's sides are equally far: nothing pushes.
    const double off_m = off_bricks_m(shape, at_m);
    touch.depth_m = -(off_m > 0.0 ? off_m + cell_m(field) : tangent_radius_m(field));
    const Eigen::Vector3d away_m = at_m - array(shape.centre_m).matrix();
    if (const double far_m = away_m.norm(); far_m > 0.0)
      touch.normal = pose.rotation * (away_m / far_m);
  }
  touch.centre_m = centre_m - (radius_m + tangent_radius_m(field) - touch.depth_m) * touch.normal;
  return touch;
}

double gap_m(const bodies::FieldBody& field, const Eigen::Vector3d& point_m,
             double radius_m) noexcept {
  if (const auto own = collision::sample(field.field->view(), point_m))
    return own->distance_m - radius_m;
  return off_bricks_m(field.field->shape(), point_m) + cell_m(field);
}

}  // namespace stillgrid::contact
