#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>

#include "shared/collision/grid_query.hpp"
#include "shared/display/transition.hpp"

namespace stillgrid::display {

/// A sphere as it is displayed. World frame.
struct DisplayedSphere {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  double presence = 1.0;  // weight of the snapshots that it is in
};

namespace detail {

[[nodiscard]] inline Eigen::Vector3d vector(const std::array<float, 3>& v) noexcept {
  return {v[0], v[1], v[2]};
}

inline void add(DisplayedSphere& sum, const proto::SphereState& snapshot, double weight,
                double velocity_s) noexcept {
  if (weight == 0.0 && velocity_s == 0.0) return;
  const Eigen::Vector3d velocity_m_s = vector(snapshot.velocity_m_s);
  sum.position_m += weight * vector(snapshot.position_m) + velocity_s * velocity_m_s;
  sum.velocity_m_s += weight * velocity_m_s;
}

}  // namespace detail

/// Whether a sphere gives way to the hand. Realtime: yes.
[[nodiscard]] inline bool is_compliant(const collision::RecordLine& line) noexcept {
  return line.response != 0;
}

/// Where the weights display a sphere: the law of docs/algorithms/transitions.md, for whoever shows
/// a scene. It is not a number where a snapshot that weighs lacks the sphere.
///
/// load_record(): the whole record, asked for only where older snapshots weigh.
/// Realtime: yes; safe on numbers that lie.
template <class LoadRecord>
[[nodiscard]] DisplayedSphere displayed(const collision::RecordLine& line,
                                        const SnapshotWeights& weights,
                                        LoadRecord&& load_record) noexcept {
  using detail::add, detail::vector;
  const auto& position = weights.position;
  const auto& velocity_s = weights.velocity_s;
  DisplayedSphere sum;
  add(sum, line.newest, position[0], velocity_s[0]);
  const double prediction_s =
      weights.prediction_s - (is_compliant(line) ? weights.compliance_lag_s : 0.0);
  sum.position_m += prediction_s * vector(line.predicted_velocity_m_s);
  const bool is_newest_only = position[1] == 0.0 && position[2] == 0.0 && position[3] == 0.0 &&
                              velocity_s[1] == 0.0 && velocity_s[2] == 0.0;
  if (is_newest_only) return sum;
  const proto::SphereRecord record = load_record();
  add(sum, record.older[0], position[1], velocity_s[1]);
  add(sum, record.older[1], position[2], velocity_s[2]);
  sum.position_m += position[3] * vector(record.oldest_position_m);
  sum.velocity_m_s += position[3] * vector(record.older[1].velocity_m_s);
  return sum;
}

/// A sphere that some snapshot lacks, displayed by those that it is in; not a number where it is in
/// none. Realtime: yes.
[[nodiscard]] inline DisplayedSphere displayed_where_present(
    const proto::SphereRecord& record, const SnapshotWeights& weights) noexcept {
  const std::array<proto::SphereState, proto::kHistoryLength> snapshots = {
      record.newest,
      record.older[0],
      record.older[1],
      {record.oldest_position_m, record.older[1].velocity_m_s}};
  DisplayedSphere sum{.presence = 0.0};
  for (std::size_t i = 0; i < snapshots.size(); ++i) {
    // Hermite's weights leave [0, 1] a little; what is negative is not there.
    const double weight = std::max(0.0, weights.position[i]);
    if (detail::vector(snapshots[i].position_m).hasNaN()) continue;
    detail::add(sum, snapshots[i], weight, 0.0);
    sum.presence += weight;
  }
  sum.position_m /= sum.presence;
  sum.velocity_m_s /= sum.presence;
  sum.presence = std::min(1.0, sum.presence);
  return sum;
}

}  // namespace stillgrid::display
