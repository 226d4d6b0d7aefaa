#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "proto/scene_segment.hpp"

namespace stillgrid::collision {

/// Where a sphere is in snapshot n - age of its history. Pre: age < kHistoryLength. Realtime: yes.
[[nodiscard]] inline const std::array<float, 3>& position_m(const proto::SphereRecord& record,
                                                            std::size_t age) noexcept {
  if (age == 0) return record.newest.position_m;
  return age <= record.older.size() ? record.older[age - 1].position_m : record.oldest_position_m;
}

/// The same snapshot throughout, without predicted velocity or response: of what stands still,
/// and of a first snapshot.
inline void fill_history(proto::SphereRecord& record, const proto::SphereState& snapshot) noexcept {
  record.newest = snapshot;
  record.older = {snapshot, snapshot};
  record.oldest_position_m = snapshot.position_m;
  record.predicted_velocity_m_s = {};
  record.response = 0;
}

/// One more snapshot; older ones move down. It moves on at its velocity, and gives no way.
inline void push_snapshot(proto::SphereRecord& record,
                          const proto::SphereState& snapshot) noexcept {
  record.oldest_position_m = record.older[1].position_m;
  record.older = {record.newest, record.older[0]};
  record.newest = snapshot;
  record.predicted_velocity_m_s = snapshot.velocity_m_s;
  record.response = 0;
}

/// Weights of a history's snapshots, newest first, told by the history of the snapshot that came
/// `later` snapshots after: those that it no longer holds count as its oldest. Realtime: yes.
template <std::size_t N>
[[nodiscard]] std::array<double, N> in_later_history(const std::array<double, N>& weights,
                                                     std::uint64_t later) noexcept {
  std::array<double, N> told{};
  for (std::size_t i = 0; i < N; ++i)
    told[i + std::min<std::uint64_t>(later, N - 1 - i)] += weights[i];
  return told;
}

}  // namespace stillgrid::collision
