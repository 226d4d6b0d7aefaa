#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "sim_server/bodies/world.hpp"

namespace stillgrid::bodies {

/// Centre and velocity of a collision sphere.
struct SphereMotion {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
};

/// Where the next step would take a sphere: at its predicted velocity if the tool's force stays as
/// it is, and by its response where that changes.
struct SpherePrediction {
  Eigen::Vector3d predicted_velocity_m_s = Eigen::Vector3d::Zero();
  std::uint32_t response = 0;  // its number among the snapshot's, from 1; 0: none
};

/// The same of a field: of its frame.
struct FieldPrediction {
  Eigen::Vector3d predicted_velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d predicted_angular_velocity_rad_s = Eigen::Vector3d::Zero();
  // Number of its origin's response among the snapshot's, from 1, behind which is how it turns; 0:
  // none.
  std::uint32_t response = 0;
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
