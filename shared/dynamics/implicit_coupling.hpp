#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "shared/dynamics/conjugate_gradients.hpp"
#include "shared/dynamics/implicit_poses.hpp"

namespace stillgrid::dynamics {

/// The point where a force acts: a weighted sum of nodes, a point of a rigid body, or a place of
/// the world.
struct ActedPoint {
  std::int32_t rigid = -1, node_count = 0;
  std::array<std::int32_t, 4> nodes{};
  std::array<double, 4> weights{};
  Eigen::Vector3d arm_m = Eigen::Vector3d::Zero();  // centre of the rigid body to the point

  void set_node(std::int32_t node) {
    node_count = 1;
    nodes[0] = node;
    weights[0] = 1.0;
  }
};

/// A force between two points over a step.
struct Coupling {
  ActedPoint a, b;
  Eigen::Vector3d impulse_N_s = Eigen::Vector3d::Zero();  // on a
  Eigen::Matrix3d slope_kg = Eigen::Matrix3d::Zero();     // its decrease by relative velocity
  bool is_active = false;                                 // else both are zero
};

/// Parts of the equations' derivative that belong to one node or one rigid body.
struct MassBlocks {
  using Block6 = Eigen::Matrix<double, 6, 6>;
  std::vector<Eigen::Matrix3d> nodes;
  std::vector<Block6, Eigen::aligned_allocator<Block6>> rigid;
};

[[nodiscard]] inline bool is_driven(const ActedPoint& point, const Description& description) {
  return point.rigid >= 0 &&
         description.rigid_bodies[static_cast<std::size_t>(point.rigid)].is_driven;
}

[[nodiscard]] inline Eigen::Vector3d across(const Eigen::Vector3d& v,
                                            const Eigen::Vector3d& normal) {
  return v - v.dot(normal) * normal;
}
[[nodiscard]] inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

[[nodiscard]] inline Eigen::Vector3d velocity_at(const ActedPoint& point, const Motions& motions,
                                                 const ImplicitPoses& poses) {
  if (point.rigid >= 0) {
    const auto r = static_cast<std::size_t>(point.rigid);
    return motions[poses.centre(r)].vector() + motions[poses.spin(r)].vector().cross(point.arm_m);
  }
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < static_cast<std::size_t>(point.node_count); ++k)
    sum += point.weights[k] * motions[static_cast<std::size_t>(point.nodes[k])].vector();
  return sum;
}
[[nodiscard]] inline Eigen::Vector3d relative_velocity(const Coupling& coupling,
                                                       const Motions& motions,
                                                       const ImplicitPoses& poses) {
  return velocity_at(coupling.a, motions, poses) - velocity_at(coupling.b, motions, poses);
}

inline void add_impulse(const ActedPoint& point, const Eigen::Vector3d& impulse,
                        const ImplicitPoses& poses, Motions& sums) {
  if (point.rigid >= 0) {
    const auto r = static_cast<std::size_t>(point.rigid);
    sums[poses.centre(r)] = sums[poses.centre(r)] + Vector4(impulse);
    sums[poses.spin(r)] = sums[poses.spin(r)] + Vector4(point.arm_m.cross(impulse));
    return;
  }
  for (std::size_t k = 0; k < static_cast<std::size_t>(point.node_count); ++k) {
    Vector4& sum = sums[static_cast<std::size_t>(point.nodes[k])];
    sum = sum + point.weights[k] * Vector4(impulse);
  }
}

/// Adds the slope by the velocity of one of the two points.
inline void add_block(const ActedPoint& point, const Coupling& coupling, MassBlocks& blocks) {
  if (point.rigid < 0) {
    for (std::size_t k = 0; k < static_cast<std::size_t>(point.node_count); ++k)
      blocks.nodes[static_cast<std::size_t>(point.nodes[k])] +=
          (point.weights[k] * point.weights[k]) * coupling.slope_kg;
    return;
  }
  auto& block = blocks.rigid[static_cast<std::size_t>(point.rigid)];
  const Eigen::Matrix3d arm = cross_matrix(point.arm_m);
  const Eigen::Matrix3d turned = arm * coupling.slope_kg;
  block.topLeftCorner<3, 3>() += coupling.slope_kg;
  block.bottomLeftCorner<3, 3>() += turned;
  block.topRightCorner<3, 3>() += turned.transpose();
  block.bottomRightCorner<3, 3>() -= turned * arm;
}

/// The torque of a pull outwards at an arm rights the body. Half of that counts, because the mean
/// arm turns by half. A push inwards would make the equations indefinite, and is left out.
inline void add_righting(const ActedPoint& point, const Eigen::Vector3d& impulse, double step_s,
                         std::vector<Eigen::Matrix3d>& spin_masses) {
  const double square = point.arm_m.squaredNorm(), pull = point.arm_m.dot(impulse);
  if (point.rigid < 0 || pull <= 0.0 || square == 0.0) return;
  spin_masses[static_cast<std::size_t>(point.rigid)] +=
      0.5 * step_s * pull *
      (Eigen::Matrix3d::Identity() - point.arm_m * point.arm_m.transpose() / square);
}

}  // namespace stillgrid::dynamics
