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

/// Turns a body without torque for `duration_s`. Keeps angular momentum and energy to rounding;
/// the orientation is of second order. Parts turn by at most half a radian; a body that turns
/// farther than sixteen keeps its axis. inertia_kg_m2: principal, in the body's frame.
void turn_freely(Eigen::Quaterniond& orientation, Eigen::Vector3d& angular_velocity_rad_s,
                 const Eigen::Vector3d& inertia_kg_m2, double duration_s);

}  // namespace stillgrid::dynamics
