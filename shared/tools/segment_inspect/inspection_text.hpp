#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
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

/// Returns the rows of json_of(summaries) as a table, a segment a line.
[[nodiscard]] std::string table_of(const nlohmann::ordered_json& segments);

/// Returns a session's JSON as indented lines, a key each; of a list at most 16 items.
[[nodiscard]] std::string detail_of(const nlohmann::ordered_json& session);

}  // namespace stillgrid::segment_inspect
