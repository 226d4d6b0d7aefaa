#pragma once

#include <cstddef>
#include <cstdint>

namespace stillgrid::dynamics {

/// Returns a number that is not negative, as an index. Realtime: yes.
[[nodiscard]] constexpr std::size_t at(std::int32_t number) noexcept {
  return static_cast<std::size_t>(number);
}

}  // namespace stillgrid::dynamics
