#pragma once

#include <Eigen/Core>
#include <span>

#include "sim_server/bodies/world.hpp"

namespace stillgrid::bodies {

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

/// sphere_motion() of many spheres, up to rounding: those of one rigid body that follow one another
/// share its rotation's matrix. Pre: nodes and bodies outlive it and do not change.
class SphereMotions {
 public:
  SphereMotions(std::span<const Node> nodes, std::span<const RigidBody> rigid_bodies)
      : nodes_(nodes), rigid_bodies_(rigid_bodies) {}

  [[nodiscard]] SphereMotion operator()(const SphereBinding& sphere);

 private:
  std::span<const Node> nodes_;
  std::span<const RigidBody> rigid_bodies_;
  int rigid_ = -1;  // whose rotation it is
  Eigen::Matrix3d rotation_;
};

}  // namespace stillgrid::bodies
