#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace stillgrid::bodies {

/// The matrix of the cross product: cross_matrix(a) * b = a x b.
[[nodiscard]] inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

/// The rotation by a rotation vector (axis times angle, rad).
[[nodiscard]] inline Eigen::Quaterniond rotation_of(const Eigen::Vector3d& vector_rad) {
  const double angle_rad = vector_rad.norm();
  // sin(a/2)/a, by its series where the quotient would lose digits.
  const double sine_ratio = angle_rad > 1e-8 ? std::sin(0.5 * angle_rad) / angle_rad : 0.5;
  const Eigen::Vector3d v = sine_ratio * vector_rad;
  return {std::cos(0.5 * angle_rad), v.x(), v.y(), v.z()};
}

/// The left Jacobian of the rotation vector: rotation_of(p + dp) = rotation_of(J dp) *
/// rotation_of(p) to first order.
[[nodiscard]] inline Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& vector_rad) {
  const double a2 = vector_rad.squaredNorm(), a = std::sqrt(a2);
  const double first = a > 1e-4 ? (1.0 - std::cos(a)) / a2 : 0.5 - a2 / 24.0;
  const double second = a > 1e-4 ? (a - std::sin(a)) / (a2 * a) : 1.0 / 6.0 - a2 / 120.0;
  const Eigen::Matrix3d cross = cross_matrix(vector_rad);
  return Eigen::Matrix3d::Identity() + first * cross + second * cross * cross;
}

}  // namespace stillgrid::bodies
