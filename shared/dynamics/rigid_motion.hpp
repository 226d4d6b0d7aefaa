#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace stillgrid::dynamics {

/// Inverse inertia in the frame of the world, 1/(kg m^2), from principal ones in the body's.
[[nodiscard]] inline Eigen::Matrix3d inverse_inertia(const Eigen::Quaterniond& orientation,
                                                     const Eigen::Vector3d& inertia_kg_m2) {
  const Eigen::Matrix3d axes = orientation.toRotationMatrix();
  return axes * inertia_kg_m2.cwiseInverse().asDiagonal() * axes.transpose();
}

/// Inertia in the frame of the world, from principal ones in the body's.
[[nodiscard]] inline Eigen::Matrix3d turned_inertia(const Eigen::Quaterniond& orientation,
                                                    const Eigen::Vector3d& inertia_kg_m2) {
  const Eigen::Matrix3d axes = orientation.toRotationMatrix();
  return axes * inertia_kg_m2.asDiagonal() * axes.transpose();
}

/// The rotation by a vector along its axis of its length in rad. Exact to rounding; sums of a
/// series instead of functions of the C library, which round differently on different processors.
/// An angle beyond 1e15 rad, of which no digit is known, gives no number.
[[nodiscard]] inline Eigen::Quaterniond rotation_by(const Eigen::Vector3d& turn_rad) {
  const double square = 0.25 * turn_rad.squaredNorm();  // half the angle, squared
  if (square > 1e30) return {NAN, NAN, NAN, NAN};
  if (square > 0.25) {
    const Eigen::Quaterniond half = rotation_by(0.5 * turn_rad);
    return (half * half).normalized();
  }
  double cosine = 1.0, sine = 1.0;  // the latter over the half angle
  for (double k = square < 1e-3 ? 6.0 : 14.0; k > 0.0; k -= 2.0) {  // to 1e-16 either way
    cosine = 1.0 - square / (k * (k - 1.0)) * cosine;
    sine = 1.0 - square / (k * (k + 1.0)) * sine;
  }
  const Eigen::Vector3d part = 0.5 * sine * turn_rad;
  return {cosine, part.x(), part.y(), part.z()};
}

/// The shortest vector v with rotation_by(v) = rotation, in rad. rotation: a unit quaternion.
[[nodiscard]] inline Eigen::Vector3d rotation_vector(Eigen::Quaterniond rotation) {
  if (rotation.w() < 0.0) rotation.coeffs() *= -1.0;
  double times = 2.0;
  while (rotation.vec().squaredNorm() > 0.01) {  // halves the angle
    rotation.w() += 1.0;
    rotation.normalize();
    times *= 2.0;
  }
  // asin(s) / s = 1 + s^2/6 + 3 s^4/40 + ...
  const double square = rotation.vec().squaredNorm();
  double term = 1.0, sum = 1.0;
  for (double k = 1.0; k < 16.0; k += 2.0) {
    term *= square * k / (k + 1.0);
    sum += term / (k + 2.0);
  }
  return times * sum * rotation.vec();
}

/// Orientation after `duration_s` at a constant angular velocity in rad/s, in the frame of the
/// world. Exact to rounding.
[[nodiscard]] inline Eigen::Quaterniond turned(const Eigen::Quaterniond& orientation,
                                               const Eigen::Vector3d& angular_velocity_rad_s,
                                               double duration_s) {
  return (rotation_by(duration_s * angular_velocity_rad_s) * orientation).normalized();
}

/// Returns the angular momentum in the body's frame after duration_s without torque. The implicit
/// midpoint rule keeps its length and the energy to rounding. The momentum stays as it is where
/// the equations have no solution nearby. inverse_inertia: principal.
[[nodiscard]] inline Eigen::Vector3d free_momentum(const Eigen::Vector3d& momentum,
                                                   const Eigen::Vector3d& inverse_inertia,
                                                   double duration_s) {
  constexpr int kIterations = 8;
  constexpr double kRounding = 2e-15;
  Eigen::Vector3d next = momentum;
  for (int k = 0; k < kIterations; ++k) {
    const Eigen::Vector3d middle = 0.5 * (momentum + next);
    const Eigen::Vector3d spin = inverse_inertia.cwiseProduct(middle);
    const Eigen::Vector3d residual = next - momentum - duration_s * middle.cross(spin);
    if (residual.norm() <= kRounding * momentum.norm()) return next;
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

/// Turns a body without torque for `duration_s`. Keeps angular momentum and energy to rounding;
/// the orientation is of second order. Parts turn by at most half a radian; a body that turns
/// farther than sixteen keeps its axis. inertia_kg_m2: principal, in the body's frame.
inline void turn_freely(Eigen::Quaterniond& orientation, Eigen::Vector3d& angular_velocity_rad_s,
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
