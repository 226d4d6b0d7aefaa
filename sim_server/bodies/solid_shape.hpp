#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <span>
#include <vector>

#include "shared/collision/distance_field.hpp"
#include "sim_server/mesh/mass_properties.hpp"
#include "sim_server/mesh/triangle_mesh.hpp"
#include "sim_server/spheres/ball.hpp"

namespace stillgrid::bodies {

/// A part of a rigid body whose distance is a closed form. The axis of a capsule or cylinder is
/// its own z axis.
struct SolidShape {
  enum class Kind { kBox, kSphere, kCapsule, kCylinder };
  Kind kind = Kind::kBox;
  Eigen::Vector3d half_m = Eigen::Vector3d::Zero();  // half of its sides along its own axes
  // Pose in the frame of the body.
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
};

/// Volume, centre and inertia of shapes of one density, in the frame of the body. A volume that
/// several of them share counts once for each.
[[nodiscard]] mesh::MassProperties mass_properties(std::span<const SolidShape> shapes);

/// The axes along which an inertia is diagonal, as columns of a rotation, and its moments along
/// them, the least first.
struct PrincipalAxes {
  Eigen::Matrix3d axes;
  Eigen::Vector3d moments;
};
[[nodiscard]] PrincipalAxes principal_axes(const Eigen::Matrix3d& inertia);

/// Returns the distance field of a shape in its own frame.
[[nodiscard]] std::shared_ptr<const collision::DistanceField> field_of(const SolidShape& shape);

/// Returns balls within the shape by which it meets planes and the fields of others, in the frame
/// of the body. A box has 8 at its corners and up to 48 along its edges, 12 if it is a cube. A
/// capsule has up to 32 of its radius on its axis. A cylinder has 16 at each rim, and as many as
/// a capsule if it is longer than wide. A sphere has itself.
[[nodiscard]] std::vector<spheres::Ball> contact_balls(const SolidShape& shape);

/// Returns whether a ball is inside the shape and does not touch its surface. The ball is in the
/// frame of the body.
[[nodiscard]] bool hides(const SolidShape& shape, const spheres::Ball& ball);

/// Returns the distance from the origin of the body to the farthest point of the shape, or more.
[[nodiscard]] double bounding_radius_m(const SolidShape& shape);

/// Adds the surface of a shape to a mesh for a display, in the frame of the body.
void add_surface(const SolidShape& shape, mesh::TriangleMesh& mesh);

}  // namespace stillgrid::bodies
