#pragma once

#include <cstdint>
#include <optional>

namespace stillgrid::devices {

/// Returns the number of allocations of this program and its plugins so far. Returns no number
/// without the address sanitizer, which counts them.
[[nodiscard]] std::optional<std::uint64_t> allocation_count() noexcept;

}  // namespace stillgrid::devices
