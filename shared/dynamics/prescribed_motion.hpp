#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace stillgrid::dynamics {

/// A displacement of a prescribed body from its start.
struct Keyframe {
  double time_s = 0.0;
  Eigen::Vector3d displacement_m = Eigen::Vector3d::Zero();
};

/// A motion that is known in advance: steady, a sine along one direction, or through keyframes.
///
/// Between keyframes the displacement is a monotone cubic in each axis. The body never goes beyond
/// the two. It rests at the start, at turns, between two that are equal, and from the last one on.
/// Source: Fritsch and Butland, A method for constructing local monotone piecewise cubic
/// interpolants, SIAM J. Sci. Stat. Comput. 5, 1984.
struct PrescribedMotion {
  using Keyframes = std::vector<Keyframe>;

  Eigen::Vector3d start_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  // unit; the sine moves along it
  double amplitude_m = 0.0;
  double frequency_hz = 0.0;
  /// Keyframes with ascending times above zero, or null. Copies share them, and do not allocate.
  std::shared_ptr<const Keyframes> keyframes = nullptr;

  /// Whether its velocity changes.
  [[nodiscard]] bool swings() const { return amplitude_m * frequency_hz != 0.0 || keyframes; }
  /// Whether it ever leaves its start.
  [[nodiscard]] bool moves() const { return !velocity_m_s.isZero(0.0) || swings(); }
  /// Returns where it is time_s after the start. Realtime: yes.
  [[nodiscard]] Eigen::Vector3d position_m(double time_s) const;
  /// Returns its velocity then, m/s. Realtime: yes.
  [[nodiscard]] Eigen::Vector3d velocity_at_m_s(double time_s) const;
  /// Returns its highest speed, m/s, of keyframes that of the fastest keyframe or middle between
  /// two.
  [[nodiscard]] double highest_speed_m_s() const;
};

}  // namespace stillgrid::dynamics
