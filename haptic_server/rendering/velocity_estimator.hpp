#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

namespace stillgrid {

/// Velocity of the tool from its positions alone, for drivers' own estimates are often wrong:
/// backward differences through a first-order low-pass of 5 ms.
///
/// Delay 5 ms on a ramp; an encoder step of d shows as at most d / 5 ms. Realtime: yes.
class VelocityEstimator {
 public:
  /// The estimate after one more sample. Samples at equal times change nothing.
  Eigen::Vector3d update(std::uint64_t time_ns, const Eigen::Vector3d& position_m) noexcept;

 private:
  bool has_sample_ = false;
  std::uint64_t time_ns_ = 0;
  Eigen::Vector3d position_m_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s_ = Eigen::Vector3d::Zero();
};

/// A rotation as axis times angle, the short way round. Realtime: yes. Pre: unit.
[[nodiscard]] Eigen::Vector3d rotation_rad(const Eigen::Quaterniond& turn) noexcept;

/// Angular velocity of the tool from its orientations, in the frame they lead to: as
/// VelocityEstimator. Exactly zero while an orientation never changed. Realtime: yes.
class AngularVelocityEstimator {
 public:
  /// The estimate after one more sample. Samples at equal times change nothing. Pre: unit.
  Eigen::Vector3d update(std::uint64_t time_ns, const Eigen::Quaterniond& orientation) noexcept;

 private:
  bool has_sample_ = false;
  std::uint64_t time_ns_ = 0;
  Eigen::Quaterniond orientation_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_rad_s_ = Eigen::Vector3d::Zero();
};

}  // namespace stillgrid
