#pragma once

#include <Eigen/Core>
#include <span>

#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"

namespace stillgrid::contact {

/// Where the frame of a body with a field is.
struct FieldPose {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // world from body

  [[nodiscard]] Eigen::Vector3d into(const Eigen::Vector3d& point_m) const {
    return rotation.transpose() * (point_m - position_m);
  }
};
/// rigid_bodies: as World::rigid_bodies.
[[nodiscard]] FieldPose pose_of(const bodies::FieldBody& field,
                                std::span<const bodies::RigidBody> rigid_bodies);

/// What a field is to a sphere: the tangent sphere, fixed to the body, that overlaps it as deep and
/// along the same normal. World frame.
///
/// Contact law, friction and response know spheres only, so a field is met as one, anew wherever
/// its force is asked for. Its radius is that of the ball that holds the solid: large beside what
/// is met, as a plane nearly, and of one scale with the solid's curvature, which it stands for in
/// Jacobians only.
struct FieldTouch {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double depth_m = 0.0;                               // negative: a gap
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // towards the other sphere
  double stiffness_scale = 1.0;                       // of the contact, over its material's
  double map_scale = 1.0;                             // of the map there
};
[[nodiscard]] inline double tangent_radius_m(const bodies::FieldBody& field) {
  return double{field.field->shape().bounding_radius_m};
}
/// Realtime: yes.
[[nodiscard]] FieldTouch touch_of(const bodies::FieldBody& field, const FieldPose& pose,
                                  const Eigen::Vector3d& centre_m, double radius_m) noexcept;

/// How far a sphere at a point of the body's frame is from the solid, negative: so deep in it. By
/// the field; off its bricks, where nothing touches, no more than it is. Realtime: yes.
[[nodiscard]] double gap_m(const bodies::FieldBody& field, const Eigen::Vector3d& point_m,
                           double radius_m) noexcept;

/// Edge of a field's fine cells: nothing of the solid is smaller.
[[nodiscard]] inline double cell_m(const bodies::FieldBody& field) {
  return double{field.field->shape().brick_m} / proto::kBrickCells;
}

/// The contact as stiff as it is there.
[[nodiscard]] inline Contact scaled(Contact contact, const FieldTouch& touch) {
  contact.material.stiffness_N_per_m *= touch.stiffness_scale;
  contact.material.damping_N_s_per_m *= touch.stiffness_scale;
  return contact;
}

}  // namespace stillgrid::contact
