#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "proto/distance_field.hpp"
#include "proto/segment_header.hpp"
#include "shared/tools/scene_relay/messages.hpp"

namespace stillgrid::scene_relay {

/// Into an array of a message; out of one std::to_array() leads.
template <class T, std::size_t N>
void copy(const std::array<T, N>& from, T (&to)[N]) {
  std::copy(from.begin(), from.end(), to);
}

/// Whether all are numbers, none of them larger.
template <class Numbers>
[[nodiscard]] bool are_bounded(const Numbers& numbers, double largest = proto::kLargestNumber) {
  // Written so that a NaN does not pass.
  return std::all_of(std::begin(numbers), std::end(numbers),
                     [largest](float x) { return std::abs(double{x}) <= largest; });
}

/// A field's state as a message tells it, and back.
[[nodiscard]] inline stillgrid_relay3_FieldState told(const proto::FieldState& state) {
  stillgrid_relay3_FieldState message{};
  copy(state.position_m, message.position_m);
  copy(state.orientation_xyzw, message.orientation_xyzw);
  copy(state.velocity_m_s, message.velocity_m_s);
  copy(state.angular_velocity_rad_s, message.angular_velocity_rad_s);
  return message;
}
[[nodiscard]] inline proto::FieldState state_of(const stillgrid_relay3_FieldState& message) {
  return {std::to_array(message.position_m), std::to_array(message.orientation_xyzw),
          std::to_array(message.velocity_m_s), std::to_array(message.angular_velocity_rad_s), 0.0F};
}

}  // namespace stillgrid::scene_relay
