#pragma once

#include <Eigen/Core>

#include "shared/dynamics/description.hpp"
#include "shared/dynamics/scene_state.hpp"

namespace stillgrid::dynamics {

/// Pose of a field's frame in the world.
struct FieldPose {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  // world from field

  [[nodiscard]] Eigen::Vector3d into(const Eigen::Vector3d& point_m) const {
    return axes.transpose() * (point_m - position_m);
  }
  [[nodiscard]] Eigen::Vector3d out_of(const Eigen::Vector3d& point_m) const {
    return position_m + axes * point_m;
  }
};
[[nodiscard]] FieldPose field_pose(const Description::Field& field, const SceneState& state);

/// The sphere that overlaps another one as deep as a field does and along the same normal. A
/// contact with the field is a contact with this sphere, which is fixed to the field's body.
///
/// Its radius is field_radius_m(): its curvature is of the scale of the solid's.
struct TangentSphere {
  double depth_m = 0.0;                               // negative: a gap
  Eigen::Vector3d normal = Eigen::Vector3d::UnitX();  // in the world, towards the other sphere
  double stiffness_scale = 1.0;  // stiffness of the contact over its material's
  double map_scale = 1.0;        // the map: the energy is k map_scale depth^2 / 2
};
/// Computes the tangent sphere for a sphere at centre_m, in the frame of the world. Realtime: yes.
[[nodiscard]] TangentSphere tangent_sphere(const Description::Field& field, const FieldPose& pose,
                                           const Eigen::Vector3d& centre_m, double radius_m);
/// The same for a proxy: see collision::flat_contact(). Realtime: yes.
[[nodiscard]] TangentSphere proxy_tangent(const Description::Field& field, const FieldPose& pose,
                                          const Eigen::Vector3d& proxy_m,
                                          const Eigen::Vector3d& device_m, double radius_m);

/// Vector to the centre of the other sphere from that of the tangent sphere. radii_m: their sum.
[[nodiscard]] inline Eigen::Vector3d tangent_line_m(const TangentSphere& tangent, double radii_m) {
  return (radii_m - tangent.depth_m) * tangent.normal;
}
/// Root of the scale of stiffness. Friction's stretch times this root stays as it is where the
/// scale changes, so that the spring keeps its energy.
[[nodiscard]] double stiffness_root(const TangentSphere& tangent);

/// Radius and centre of a ball that holds the solid. The centre is in the field's frame.
[[nodiscard]] inline double field_radius_m(const Description::Field& field) {
  return double{field.distance->shape().bounding_radius_m};
}
[[nodiscard]] Eigen::Vector3d field_centre_m(const Description::Field& field);
/// See collision::detail_m().
[[nodiscard]] inline double field_cell_m(const Description::Field& field) {
  return collision::detail_m(field.distance->shape());
}
/// Bounds the speed of all points of the solid.
[[nodiscard]] double field_speed_m_s(const Description::Field& field, const SceneState& state);
/// Bounds how far any point of the solid has moved from one pose to another.
[[nodiscard]] double field_motion_m(const Description::Field& field, const FieldPose& from,
                                    const FieldPose& to);
/// Returns false where the field cannot push a sphere that moves by path_m from point_m, in the
/// field's frame. A field pushes only within its bricks. Realtime: yes.
[[nodiscard]] bool may_touch(const Description::Field& field, const Eigen::Vector3d& point_m,
                             double radius_m, double path_m);

/// Returns a lower bound of the distance between a point of the field's frame and the solid.
/// Negative where the point may be inside.
[[nodiscard]] double least_distance_m(const Description::Field& field,
                                      const Eigen::Vector3d& point_m);

}  // namespace stillgrid::dynamics
