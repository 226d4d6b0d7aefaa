#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "sim_server/bodies/world.hpp"

namespace stillgrid::dynamics {

/// A vector of a node, padded to what one vector register takes.
struct alignas(32) PackedVector {
  double x = 0.0, y = 0.0, z = 0.0, zero = 0.0;

  [[nodiscard]] auto map() { return Eigen::Map<Eigen::Vector3d>(&x); }
  [[nodiscard]] auto map() const { return Eigen::Map<const Eigen::Vector3d>(&x); }
};

/// A rigid body between two substeps. What does not feel forces has inverse masses of zero.
struct RigidState {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // the orientation's
  Eigen::Vector3d angular_momentum_N_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin_rad_s = Eigen::Vector3d::Zero();
  double inverse_mass_per_kg = 0.0;
  Eigen::Vector3d inverse_principal_inertia_per_kg_m2 = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inverse_inertia_per_kg_m2 = Eigen::Matrix3d::Zero();  // world frame
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque_N_m = Eigen::Vector3d::Zero();
  bool free = false;  // feels forces

  /// After the orientation.
  void turn_inertia() {
    rotation = orientation.toRotationMatrix();
    inverse_inertia_per_kg_m2 =
        rotation * inverse_principal_inertia_per_kg_m2.asDiagonal() * rotation.transpose();
  }
};

/// For how long forces change velocities, and the new velocities positions.
struct Move {
  double kick_s = 0.0, drift_s = 0.0;
};

/// Nodes from first on, before last.
struct NodeRange {
  std::size_t first = 0, last = 0;
};

/// All that an explicit integrator moves, as it needs it.
struct ExplicitState {
  std::vector<PackedVector> position_m, velocity_m_s, force_N;  // as World::nodes
  std::vector<double> inverse_mass_per_kg;                      // zero: pinned or sleeping
  std::vector<RigidState> rigid;                                // as World::rigid_bodies
};

}  // namespace stillgrid::dynamics
