#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace stillgrid::device_check {

/// Calls in a sequence of random calls.
inline constexpr std::size_t kFuzzCalls = 40;

/// The calls of that sequence which are kept, by their names, as "open, activate, read(), close".
/// Depends on nothing but its arguments, as does what check "fuzz.order" calls.
[[nodiscard]] std::string fuzz_text(std::uint64_t seed, std::uint64_t sequence,
                                    const std::vector<std::size_t>& kept);

/// Leaves calls out of a sequence that fails, as long as it fails without them: halves, then
/// quarters, down to single calls. Returns what is kept; nothing if the whole does not fail. fails
/// is asked at most 200 times.
[[nodiscard]] std::vector<std::size_t> shrink_calls(
    const std::function<bool(const std::vector<std::size_t>& kept)>& fails);

}  // namespace stillgrid::device_check
