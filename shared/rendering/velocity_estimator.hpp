#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

namespace stillgrid::rendering {

/// Velocity of the tool from its positions alone, for drivers' own estimates are often wrong:
/// the slopes between samples through a first-order low-pass of 5 ms.
///
/// Delay 5 ms (5.02 ms at 1 kHz). Noise: positions rounded to steps of d move an estimate by at
/// most d / 5 ms, those of moving hands by d / 19 ms rms (measured, 1 kHz). All weights are
/// positive: an estimate lies among the slopes of the past, so that it never overshoots, and a
/// gap in the samples shows as the mean velocity over it. Why this one:
/// docs/algorithms/velocity.md. Realtime: yes; constant time and memory.
class VelocityEstimator {
 public:
  /// The estimate after one more sample. A sample whose stamp is not later than the one before
  /// changes nothing, so that a device's repeated sample under its own stamp is no standstill.
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
  /// The estimate after one more sample, as VelocityEstimator::update(). Pre: unit.
  Eigen::Vector3d update(std::uint64_t time_ns, const Eigen::Quaterniond& orientation) noexcept;

 private:
  bool has_sample_ = false;
  std::uint64_t time_ns_ = 0;
  Eigen::Quaterniond orientation_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_rad_s_ = Eigen::Vector3d::Zero();
};

}  // namespace stillgrid::rendering
