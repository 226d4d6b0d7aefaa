#pragma once

#include <Eigen/Core>

namespace stillgrid::dynamics {

/// A motion that is known in advance: steady, and a sine along one direction.
struct PrescribedMotion {
  Eigen::Vector3d start_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  // unit; the sine moves along it
  double amplitude_m = 0.0;
  double frequency_hz = 0.0;

  /// Whether it turns back.
  [[nodiscard]] bool swings() const { return amplitude_m * frequency_hz != 0.0; }
  /// Whether it ever leaves its start.
  [[nodiscard]] bool moves() const { return !velocity_m_s.isZero(0.0) || swings(); }
  /// Returns where it is time_s after the start. Realtime: yes.
  [[nodiscard]] Eigen::Vector3d position_m(double time_s) const;
};

}  // namespace stillgrid::dynamics
