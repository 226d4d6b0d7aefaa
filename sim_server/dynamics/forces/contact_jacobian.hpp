#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"
#include "sim_server/dynamics/solvers/nonlinear_solver.hpp"

namespace stillgrid::dynamics {

/// One side of a contact: what moves its sphere, a rigid body or nodes, and how.
struct ContactSide {
  double sign = 0.0;                                // of the force on it
  double share = 0.0;                               // of the line of centres
  int body = bodies::kNoUnknown;                    // first unknown of a rigid body; or the nodes
  Eigen::Vector3d arm_m = Eigen::Vector3d::Zero();  // from the body's centre to the sphere's
  Eigen::Vector3d spin_rad_s = Eigen::Vector3d::Zero();  // of the body
  Eigen::Matrix3d turn_s = Eigen::Matrix3d::Zero();      // d(its turning, world frame) / d spin
  // The arm of what presses, less arm_m, and d(that arm) / d spin.
  Eigen::Vector3d press_arm_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d press_arm_by_spin_m_s = Eigen::Matrix3d::Zero();
  int node_count = 0;
  std::array<int, 4> unknowns{};
  std::array<double, 4> weights{};

  [[nodiscard]] bool moves() const { return body != bodies::kNoUnknown || node_count > 0; }
};

/// A side from where its sphere's nodes or body are. turn_s: of each rigid body; not read where it
/// has no unknowns.
[[nodiscard]] ContactSide contact_side(std::span<const bodies::Node> nodes,
                                       std::span<const bodies::RigidBody> rigid_bodies,
                                       std::span<const Eigen::Matrix3d> turn_s,
                                       const bodies::SphereBinding& sphere, double sign,
                                       double share);

/// How a contact resists over an implicit stage. The force on a and, below it, the couple that
/// friction exerts on either side's spin change by
///   by_position * d(place of a seen from b) + by_motion * (d velocity; d spin).
/// A symmetric Jacobian has what place changes in by_motion: it changes by the stage's time times
/// velocities.
struct ContactJacobian {
  ContactSide a, b;
  bool is_exact = false;
  Eigen::Matrix<double, 6, 3> by_position = Eigen::Matrix<double, 6, 3>::Zero();
  Eigen::Matrix<double, 6, 6> by_motion;
  // Of an exact one: on a.
  Eigen::Matrix3d press_by_position = Eigen::Matrix3d::Zero();
  Eigen::Vector3d press_N = Eigen::Vector3d::Zero(), friction_N = Eigen::Vector3d::Zero();
};

/// The Jacobian of a contact that touches; sides are left to the caller.
[[nodiscard]] ContactJacobian contact_jacobian(const contact::ContactForce& force,
                                               const contact::ContactDerivatives& derivatives,
                                               JacobianKind jacobian, double stage_s);

/// y += d(momentum - s force) / du x.
void multiply_add(const ContactJacobian& jacobian, double stage_s, const Eigen::VectorXd& x,
                  Eigen::VectorXd& y);

/// Adds its blocks on the diagonal to those of all unknowns, side by side.
void add_diagonal(const ContactJacobian& jacobian, double stage_s, Eigen::Matrix3Xd& blocks);

}  // namespace stillgrid::dynamics
