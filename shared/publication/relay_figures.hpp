#pragma once

#include <cstdint>
#include <optional>

#include "proto/segment_header.hpp"

namespace stillgrid::publication {

/// A program shows no count of a relay's above this: all below are exact in a double, and in a
/// page.
inline constexpr std::uint64_t kLargestRelayCount = std::uint64_t{1} << 53;

/// Nor a time, of a clock's offset either way (ns): 32 years.
inline constexpr std::uint64_t kLongestRelayTime_ns = 1'000'000'000'000'000'000;

/// Writes them into a segment that is this relay's own, word by word. Thread: one. Realtime: yes.
void store_relay_figures(proto::SegmentHeader& header, const proto::RelayFigures& figures) noexcept;

/// Of a segment that a relay writes what it tells now; nothing of any other, nor where the words
/// are none that a relay writes. live: the header in place (SegmentReader::live()). Thread: any.
/// Realtime: yes.
[[nodiscard]] std::optional<proto::RelayFigures> load_relay_figures(
    const proto::SegmentHeader& live) noexcept;

/// Whether all counts and times are bounded by those above, and `connected` is 0 or 1.
[[nodiscard]] bool is_sound(const proto::RelayFigures& figures) noexcept;

}  // namespace stillgrid::publication
