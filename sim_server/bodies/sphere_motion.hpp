#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "sim_server/bodies/world.hpp"

namespace stillgrid {

/// Centre and velocity of a collision sphere.
struct SphereMotion {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
};

/// Where a sphere is, from the nodes or the rigid body it is bound to.
[[nodiscard]] SphereMotion sphere_motion(std::span<const Node> nodes,
                                         std::span<const RigidBody> rigid_bodies,
                                         const SphereBinding& sphere);
[[nodiscard]] inline SphereMotion sphere_motion(const World& world, const SphereBinding& sphere) {
  return sphere_motion(world.nodes, world.rigid_bodies, sphere);
}

/// How one block of three velocity unknowns u moves a sphere over an implicit step.
struct SpherePart {
  int unknown = kNoUnknown;
  bool is_rotation = false;
  Eigen::Matrix3d lever = Eigen::Matrix3d::Zero();  // d velocity / du at the given pose: forces go
                                                    // back by its transpose
  Eigen::Matrix3d position_by_unknown =
      Eigen::Matrix3d::Zero();  // d position / du, through the step
  Eigen::Matrix3d velocity_by_unknown =
      Eigen::Matrix3d::Zero();  // d velocity / du, through the step
};

/// All blocks that move a sphere.
struct SphereParts {
  int count = 0;
  std::array<SpherePart, 4> parts;

  [[nodiscard]] std::span<const SpherePart> all() const {
    return {parts.data(), static_cast<std::size_t>(count)};
  }
};
[[nodiscard]] SphereParts sphere_parts(std::span<const Node> nodes,
                                       std::span<const RigidBody> rigid_bodies,
                                       const SphereBinding& sphere, double step_s);

}  // namespace stillgrid
