#pragma once

#include <Eigen/Core>
#include <array>

#include "proto/scene_segment.hpp"
#include "shared/display/transition.hpp"

namespace stillgrid::display {

/// A sphere as it is displayed. World frame.
struct DisplayedSphere {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  double presence = 1.0;  // weight of the snapshots that it is in
};

/// Returns where the weights display a sphere, for whoever shows a scene. A sphere that one of the
/// two snapshots lacks is displayed where the other has it. The position is not a number where no
/// snapshot that weighs has it. Realtime: yes; safe on numbers that lie.
[[nodiscard]] inline DisplayedSphere displayed(const proto::SphereRecord& record,
                                               const SnapshotWeights& weights) noexcept {
  const auto vector = [](const std::array<float, 3>& v) {
    return Eigen::Vector3d(v[0], v[1], v[2]);
  };
  const Eigen::Vector3d newest_m = vector(record.newest.position_m),
                        before_m = vector(record.before.position_m),
                        newest_m_s = vector(record.newest.velocity_m_s),
                        before_m_s = vector(record.before.velocity_m_s);
  const double alpha = weights.alpha;
  if (alpha == 1.0) return {newest_m, newest_m_s};
  if (newest_m.hasNaN()) return {before_m, before_m_s, 1.0 - alpha};
  if (before_m.hasNaN()) return {newest_m, newest_m_s, alpha};
  return {alpha * newest_m + (1.0 - alpha) * before_m,
          alpha * newest_m_s + (1.0 - alpha) * before_m_s};
}

}  // namespace stillgrid::display
