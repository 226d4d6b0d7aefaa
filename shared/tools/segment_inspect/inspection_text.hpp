#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "shared/tools/segment_inspect/segment_summary.hpp"

namespace stillgrid::segment_inspect {

/// Words that tables and JSON share.
[[nodiscard]] std::string_view name_of(proto::SegmentKind kind) noexcept;
[[nodiscard]] std::string_view name_of(reading::SegmentState state) noexcept;
[[nodiscard]] std::string_view name_of(proto::Clock clock) noexcept;

/// "0x" and sixteen digits.
[[nodiscard]] std::string hexadecimal(std::uint64_t value);

/// Hz of a period. Pre: period_ns > 0.
[[nodiscard]] double rate_of(std::uint64_t period_ns) noexcept;

/// "812 B", "4.0 KiB", "1.2 MiB".
[[nodiscard]] std::string size_text(std::uint64_t bytes);

/// How a relay's segment came, one line: "connected, round trip 20.3 ms, clock +1.2 s +- 0.1 ms,
/// 12,345 received (4.5 MiB), 12 lost", and of the other counts those that are not 0.
[[nodiscard]] std::string relay_text(const proto::RelayFigures& figures);

/// A table for people, a row a segment, one line each.
[[nodiscard]] std::string table_of(std::span<const reading::SegmentSummary> summaries);

/// All that a session's segments hold but the single spheres. Each may be null.
[[nodiscard]] std::string detail_of(const std::string& session,
                                    const reading::ObservedSegment* scene,
                                    const reading::ObservedSegment* tool);

}  // namespace stillgrid::segment_inspect
