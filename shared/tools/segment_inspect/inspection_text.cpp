#include "shared/tools/segment_inspect/inspection_text.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <vector>

namespace stillgrid::segment_inspect {
namespace {

constexpr std::size_t kColumns = 11;
using Row = std::array<std::string, kColumns>;
const Row kHead{"SESSION",  "KIND",     "WRITER", "VERSION", "CLOCK", "DECLARED",
                "MEASURED", "SNAPSHOT", "AGE",    "SPHERES", "SIZE"};
constexpr std::size_t kFirstRightAligned = 5;

/// A dash for what is not known.
template <class T>
std::string cell(const std::optional<T>& value, const char* format, double factor = 1.0) {
  return value ? fmt::format(fmt::runtime(format), static_cast<double>(*value) * factor) : "-";
}

std::string spheres_of(const reading::SegmentSummary& summary) {
  if (!summary.static_spheres) return "-";
  return fmt::format("{}+{}", cell(summary.moving_spheres, "{:.0f}"), *summary.static_spheres);
}

/// A segment that cannot be read, or not yet: what is the matter with it, from its third column on.
std::string complaint_of(const reading::SegmentSummary& summary) {
  switch (summary.state) {
    case reading::SegmentState::kRefused:
      return "refused: " + summary.refusal;
    case reading::SegmentState::kStarting:
      return "starting: its writer has not announced it yet";
    case reading::SegmentState::kHalfMade:
      return "dead: its writer was killed before it announced it";
    default:
      return {};
  }
}

Row row_of(const reading::SegmentSummary& summary) {
  Row row;
  row[0] = reading::printable(summary.file.session);
  row[1] = name_of(summary.file.kind);
  row[2] = complaint_of(summary);
  if (!summary.header || !row[2].empty()) return row;
  const proto::SegmentHeader& header = *summary.header;
  const bool is_alive = summary.state == reading::SegmentState::kAlive;
  row[2] = is_alive ? fmt::format("pid {}", header.writer_pid) : "dead";
  row[3] = std::to_string(header.version);
  row[4] = name_of(header.clock);
  row[5] = fmt::format("{:.1f} Hz", rate_of(header.period_ns));
  row[6] = cell(summary.measured_rate_hz, "{:.1f} Hz");
  row[7] = std::to_string(header.latest);
  row[8] = cell(summary.age_s, "{:.1f} ms", 1e3);
  row[9] = spheres_of(summary);
  row[10] = size_text(summary.size_bytes);
  return row;
}

}  // namespace

std::string_view name_of(proto::SegmentKind kind) noexcept {
  return kind == proto::SegmentKind::kScene ? "scene" : "tool";
}

std::string_view name_of(reading::SegmentState state) noexcept {
  switch (state) {
    case reading::SegmentState::kAlive:
      return "alive";
    case reading::SegmentState::kDead:
      return "dead";
    case reading::SegmentState::kStarting:
      return "starting";
    case reading::SegmentState::kHalfMade:
      return "half_made";
    case reading::SegmentState::kRefused:
      return "refused";
    case reading::SegmentState::kGone:
      return "gone";
  }
  return "gone";
}

std::string_view name_of(proto::Clock clock) noexcept {
  switch (clock) {
    case proto::Clock::kMonotonic:
      return "monotonic";
    case proto::Clock::kVirtual:
      return "virtual";
  }
  return "unknown";
}

std::string hexadecimal(std::uint64_t value) {
  return fmt::format("0x{:016x}", value);
}

double rate_of(std::uint64_t period_ns) noexcept {
  return 1e9 / static_cast<double>(period_ns);
}

std::string size_text(std::uint64_t bytes) {
  if (bytes < 1024) return fmt::format("{} B", bytes);
  constexpr std::array kUnits{"KiB", "MiB", "GiB", "TiB"};
  double size = static_cast<double>(bytes) / 1024.0;
  std::size_t unit = 0;
  for (; size >= 1023.95 && unit + 1 < kUnits.size(); ++unit) size /= 1024.0;
  return fmt::format("{:.1f} {}", size, kUnits[unit]);
}

std::string table_of(std::span<const reading::SegmentSummary> summaries) {
  if (summaries.empty()) return "no session in shared memory\n";
  std::vector<Row> rows{kHead};
  std::transform(summaries.begin(), summaries.end(), std::back_inserter(rows), row_of);
  std::array<std::size_t, kColumns> widths{};
  for (const Row& row : rows)
    for (std::size_t i = 0; i < kColumns; ++i)
      if (i < 2 || !row.back().empty()) widths[i] = std::max(widths[i], row[i].size());
  std::string text;
  for (const Row& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < kColumns; ++i)
      line += i < kFirstRightAligned ? fmt::format("{:<{}}  ", row[i], widths[i])
                                     : fmt::format("{:>{}}  ", row[i], widths[i]);
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  }
  return text;
}

}  // namespace stillgrid::segment_inspect
