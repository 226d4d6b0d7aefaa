#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>

#include "proto/scene_segment.hpp"
#include "shared/collision/unit_quaternion.hpp"

namespace stillgrid::collision {

/// Whether a field's state is one that may be: numbers within bounds, and nearly a unit quaternion.
/// Realtime: yes.
[[nodiscard]] inline bool is_sound(const proto::FieldState& state) noexcept {
  // Written so that a NaN does not pass.
  const auto are_bounded = [](const std::array<float, 3>& numbers) {
    return std::all_of(numbers.begin(), numbers.end(),
                       [](float x) { return std::abs(double{x}) <= proto::kLargestNumber; });
  };
  return are_bounded(state.position_m) && are_bounded(state.velocity_m_s) &&
         are_bounded(state.angular_velocity_rad_s) && is_unit(state.orientation_xyzw);
}

/// The same snapshot twice, of a first one.
inline void fill_history(proto::FieldRecord& record, const proto::FieldState& snapshot) noexcept {
  record.history.fill(snapshot);
}

/// One more snapshot. Of the two quaternions of its turn it keeps the one that is nearer to that of
/// the snapshot before: what is shown between the two goes the short way round.
inline void push_snapshot(proto::FieldRecord& record, const proto::FieldState& snapshot) noexcept {
  record.history = {snapshot, record.history[0]};
  auto& turn = record.history[0].orientation_xyzw;
  const auto& was = record.history[1].orientation_xyzw;
  const auto vector = [](const auto& q) { return Eigen::Map<const Eigen::Vector4f>(q.data()); };
  if (vector(turn).dot(vector(was)) < 0.0F)
    std::transform(turn.begin(), turn.end(), turn.begin(), std::negate());
}

}  // namespace stillgrid::collision
