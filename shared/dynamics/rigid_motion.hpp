#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace stillgrid::dynamics {

/// Inverse inertia in the frame of the world, 1/(kg m^2), from principal ones in the body's.
[[nodiscard]] inline Eigen::Matrix3d inverse_inertia(const Eigen::Quaterniond& orientation,
                                                     const Eigen::Vector3d& inertia_kg_m2) {
  const Eigen::Matrix3d axes = orientation.toRotationMatrix();
  return axes * inertia_kg_m2.cwiseInverse().asDiagonal() * axes.transpose();
}

/// Orientation after `duration_s` at a constant angular velocity in rad/s, in the frame of the
/// world. Exact.
[[nodiscard]] inline Eigen::Quaterniond turned(const Eigen::Quaterniond& orientation,
                                               const Eigen::Vector3d& angular_velocity_rad_s,
                                               double duration_s) {
  const Eigen::Vector3d turn = duration_s * angular_velocity_rad_s;
  const double angle = turn.norm();
  if (angle == 0.0) return orientation;
  const Eigen::Vector3d part = std::sin(0.5 * angle) / angle * turn;
  const Eigen::Quaterniond by(std::cos(0.5 * angle), part.x(), part.y(), part.z());
  return (by * orientation).normalized();
}

/// Turns a body without torque for `duration_s` by Heun's method; keeps its angular momentum to
/// rounding, its energy to second order. inertia_kg_m2: principal, in the body's frame.
inline void turn_freely(Eigen::Quaterniond& orientation, Eigen::Vector3d& angular_velocity_rad_s,
                        const Eigen::Vector3d& inertia_kg_m2, double duration_s) {
  if (inertia_kg_m2.x() == inertia_kg_m2.y() && inertia_kg_m2.y() == inertia_kg_m2.z()) {
    orientation = turned(orientation, angular_velocity_rad_s, duration_s);
    return;
  }
  const Eigen::Vector3d momentum =
      orientation *
      inertia_kg_m2.cwiseProduct(orientation.conjugate() * angular_velocity_rad_s).eval();
  const auto velocity_at = [&](const Eigen::Quaterniond& q) -> Eigen::Vector3d {
    return q * (q.conjugate() * momentum).cwiseQuotient(inertia_kg_m2).eval();
  };
  const Eigen::Quaterniond guess = turned(orientation, angular_velocity_rad_s, duration_s);
  orientation = turned(orientation, 0.5 * (angular_velocity_rad_s + velocity_at(guess)), duration_s);
  angular_velocity_rad_s = velocity_at(orientation);
}

}  // namespace stillgrid::dynamics
