#pragma once

#include <cstdint>

namespace stillgrid::display {

/// From one stamp to a later one; zero if it is no later. Realtime: yes.
[[nodiscard]] constexpr double seconds_between(std::uint64_t from_ns,
                                               std::uint64_t to_ns) noexcept {
  return to_ns > from_ns ? static_cast<double>(to_ns - from_ns) * 1e-9 : 0.0;
}

}  // namespace stillgrid::display
