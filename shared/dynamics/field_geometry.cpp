#include "shared/dynamics/field_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "shared/collision/exact_shape.hpp"

namespace stillgrid::dynamics {
namespace {

/// A field may exceed the distance by these shares: of the distance, and of a coarse cell.
constexpr double kSlack = 0.05;

Eigen::Array3d array(const std::array<float, 3>& v) {
  return Eigen::Map<const Eigen::Array3f>(v.data()).cast<double>();
}

/// The nearest point in the box of the bricks, in which the solid lies. A closed form has no box.
Eigen::Vector3d nearest_in_bricks_m(const proto::FieldShape& shape,
                                    const Eigen::Vector3d& point_m) {
  if (collision::is_exact(shape)) return point_m;
  constexpr double kWithin = 1.0 - 1e-6;  // the upper sides have no sample
  const Eigen::Array3d low_m = array(shape.lowest_m);
  const Eigen::Array3d high_m =
      low_m +
      kWithin * double{shape.brick_m} *
          Eigen::Map<const Eigen::Array<std::uint32_t, 3, 1>>(shape.bricks.data()).cast<double>();
  return point_m.array().max(low_m).min(high_m).matrix();
}

}  // namespace

FieldPose field_pose(const Description::Field& field, const SceneState& state) {
  const auto rigid = static_cast<std::size_t>(field.rigid);
  const Eigen::Matrix3d axes = state.orientation[rigid].quaternion().toRotationMatrix();
  return {state.rigid_position_m[rigid].vector() + axes * field.position_m,
          axes * field.orientation.toRotationMatrix()};
}

namespace {

TangentSphere tangent_of(const Description::Field& field, const FieldPose& pose,
                         const Eigen::Vector3d& at_m,
                         const std::optional<collision::FieldContact>& own) {
  if (own) return {own->depth_m, pose.axes * own->normal, own->stiffness_scale, own->map_scale};
  // Nothing pushes off the bricks, or where the sides of the solid are equally far.
  TangentSphere tangent{.depth_m = -field_radius_m(field)};
  const Eigen::Vector3d away_m = at_m - field_centre_m(field);
  if (const double far_m = away_m.norm(); far_m > 0.0)
    tangent.normal = pose.axes * (away_m / far_m);
  return tangent;
}

}  // namespace

TangentSphere tangent_sphere(const Description::Field& field, const FieldPose& pose,
                             const Eigen::Vector3d& centre_m, double radius_m) {
  const Eigen::Vector3d at_m = pose.into(centre_m);
  return tangent_of(field, pose, at_m,
                    collision::field_contact(field.distance->view(), at_m, radius_m));
}

TangentSphere proxy_tangent(const Description::Field& field, const FieldPose& pose,
                            const Eigen::Vector3d& proxy_m, const Eigen::Vector3d& device_m,
                            double radius_m) {
  const Eigen::Vector3d at_m = pose.into(proxy_m);
  const collision::FieldView view = field.distance->view();
  auto own = collision::field_contact(view, at_m, radius_m);
  if (own && collision::is_flat(*own))
    own = collision::flat_contact(view, *own, at_m, pose.into(device_m), radius_m);
  return tangent_of(field, pose, at_m, own);
}

double stiffness_root(const TangentSphere& tangent) {
  constexpr double kLeastScale = 1e-6;  // stretches are divided by the root
  return std::sqrt(std::max(kLeastScale, tangent.stiffness_scale));
}

Eigen::Vector3d field_centre_m(const Description::Field& field) {
  return array(field.distance->shape().centre_m).matrix();
}

double field_speed_m_s(const Description::Field& field, const SceneState& state) {
  const auto rigid = static_cast<std::size_t>(field.rigid);
  const Eigen::Vector3d centre_m = field.position_m + field.orientation * field_centre_m(field);
  return state.rigid_velocity_m_s[rigid].vector().norm() +
         state.angular_velocity_rad_s[rigid].vector().norm() *
             (centre_m.norm() + field_radius_m(field));
}

double field_motion_m(const Description::Field& field, const FieldPose& from, const FieldPose& to) {
  const Eigen::Vector3d centre_m = field_centre_m(field);
  const Eigen::Matrix3d turn = to.axes - from.axes;
  const double chord = turn.norm() / std::numbers::sqrt2;  // of the farthest point of a unit ball
  return (to.position_m - from.position_m + turn * centre_m).norm() + chord * field_radius_m(field);
}

bool may_touch(const Description::Field& field, const Eigen::Vector3d& point_m, double radius_m,
               double path_m) {
  const Eigen::Vector3d in_bricks_m = nearest_in_bricks_m(field.distance->shape(), point_m);
  const double off_m = (point_m - in_bricks_m).norm();
  return off_m <= path_m && least_distance_m(field, in_bricks_m) <= radius_m + off_m + path_m;
}

double least_distance_m(const Description::Field& field, const Eigen::Vector3d& point_m) {
  const proto::FieldShape& shape = field.distance->shape();
  const double off_m = (point_m - nearest_in_bricks_m(shape, point_m)).norm();
  if (off_m > 0.0) return off_m + field_cell_m(field);  // bricks reach farther than that
  const auto own = collision::sample(field.distance->view(), point_m);
  if (!own) return 0.0;
  if (collision::is_exact(shape)) return own->distance_m;
  return own->distance_m - kSlack * (std::abs(own->distance_m) + double{shape.brick_m});
}

}  // namespace stillgrid::dynamics
