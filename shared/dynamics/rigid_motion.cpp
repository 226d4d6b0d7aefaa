#include "shared/dynamics/rigid_motion.hpp"

#include <Eigen/LU>
#include <algorithm>

namespace stillgrid::dynamics {
namespace {

// Returns the angular momentum in the body's frame after duration_s without torque. The implicit
// midpoint rule keeps its length and the energy to rounding. The momentum stays as it is where
// the equations have no solution nearby. inverse_inertia: principal.
Eigen::Vector3d free_momentum(const Eigen::Vector3d& momentum,
                              const Eigen::Vector3d& inverse_inertia, double duration_s) {
  constexpr int kNewtonIterations = 8;
  constexpr double kSmallestResidual = 2e-15;
  Eigen::Vector3d next = momentum;
  for (int k = 0; k < kNewtonIterations; ++k) {
    const Eigen::Vector3d middle = 0.5 * (momentum + next);
    const Eigen::Vector3d spin = inverse_inertia.cwiseProduct(middle);
    const Eigen::Vector3d residual = next - momentum - duration_s * middle.cross(spin);
    if (residual.norm() <= kSmallestResidual * momentum.norm()) return next;
    Eigen::Matrix3d derivative = Eigen::Matrix3d::Identity();
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d unit = Eigen::Vector3d::Unit(i);
      derivative.col(i) -=
          0.5 * duration_s * (unit.cross(spin) + middle.cross(inverse_inertia.cwiseProduct(unit)));
    }
    next -= derivative.inverse() * residual;
  }
  return (next - momentum).norm() < momentum.norm() ? next : momentum;
}

}  // namespace

void turn_freely(Eigen::Quaterniond& orientation, Eigen::Vector3d& angular_velocity_rad_s,
                 const Eigen::Vector3d& inertia_kg_m2, double duration_s) {
  constexpr double kLargestTurn_rad = 0.5, kMaxParts = 32.0;
  const double turn_rad = angular_velocity_rad_s.norm() * duration_s;
  if (turn_rad == 0.0) return;
  if (inertia_kg_m2.x() == inertia_kg_m2.y() && inertia_kg_m2.y() == inertia_kg_m2.z()) {
    orientation = turned(orientation, angular_velocity_rad_s, duration_s);
    return;
  }
  const Eigen::Vector3d inverse = inertia_kg_m2.cwiseInverse();
  const Eigen::Vector3d here =
      inertia_kg_m2.cwiseProduct(orientation.conjugate() * angular_velocity_rad_s);
  const Eigen::Vector3d momentum = orientation * here;  // in the frame of the world
  Eigen::Vector3d own = here;                           // in the body's
  const double parts = std::ceil(turn_rad / kLargestTurn_rad);
  const double part_s = duration_s / std::min(parts, kMaxParts);
  for (double k = 0.0; k < std::min(parts, kMaxParts); ++k) {
    const Eigen::Vector3d next = parts > kMaxParts ? own : free_momentum(own, inverse, part_s);
    const Eigen::Vector3d spin = orientation * inverse.cwiseProduct(0.5 * (own + next)).eval();
    orientation = turned(orientation, spin, part_s);
    orientation = (Eigen::Quaterniond::FromTwoVectors(orientation * next, momentum) * orientation)
                      .normalized();
    own = next;
  }
  angular_velocity_rad_s = orientation * inverse.cwiseProduct(own).eval();
}

}  // namespace stillgrid::dynamics
