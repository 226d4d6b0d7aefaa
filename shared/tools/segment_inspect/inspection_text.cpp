#include "shared/tools/segment_inspect/inspection_text.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <nlohmann/json.hpp>
#include <vector>

namespace stillgrid::segment_inspect {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kColumns = 11;
using Row = std::array<std::string, kColumns>;
const Row kHead{"SESSION",  "KIND",     "WRITER", "VERSION", "CLOCK", "DECLARED",
                "MEASURED", "SNAPSHOT", "AGE",    "SPHERES", "SIZE"};
constexpr std::size_t kFirstRightAligned = 5;
constexpr std::size_t kMaxItems = 16;  // shown of a list; --json has all

/// A dash for what is not known.
std::string cell(const Json& value, const char* format, double factor = 1.0) {
  return value.is_null() ? "-" : fmt::format(fmt::runtime(format), value.get<double>() * factor);
}

/// A segment that cannot be read, or not yet: what is the matter with it, from its third column on.
std::string complaint_of(const Json& segment) {
  const std::string& state = segment["state"].get_ref<const std::string&>();
  if (state == "refused") return "refused: " + segment["refusal"].get<std::string>();
  if (state == "starting") return "starting: its writer has not announced it yet";
  if (state == "half_made") return "dead: its writer was killed before it announced it";
  return {};
}

Row row_of(const Json& segment) {
  Row row;
  row[0] = reading::printable(segment["session"].get<std::string>());
  row[1] = segment["kind"];
  row[2] = complaint_of(segment);
  if (segment["version"].is_null() || !row[2].empty()) return row;
  row[2] = segment["state"] == "alive" ? "pid " + segment["writer_pid"].dump() : "dead";
  row[3] = segment["version"].dump();
  row[4] = segment["clock"];
  row[5] = cell(segment["declared_rate_hz"], "{:.1f} Hz");
  row[6] = cell(segment["measured_rate_hz"], "{:.1f} Hz");
  row[7] = segment["snapshot_id"].dump();
  row[8] = cell(segment["age_s"], "{:.1f} ms", 1e3);
  row[9] = segment["static_spheres"].is_null()
               ? "-"
               : cell(segment["moving_spheres"], "{:.0f}") + "+" + segment["static_spheres"].dump();
  row[10] = size_text(segment["size_bytes"]);
  return row;
}

/// A value as one line: lists in round brackets, objects as their keys and values.
std::string value_text(const Json& value) {
  if (value.is_null()) return "none";
  if (value.is_string()) return reading::printable(value.get<std::string>());
  if (value.is_number_float()) return fmt::format("{:.6g}", value.get<double>());
  if (!value.is_structured()) return value.dump();
  std::string text;
  std::size_t shown = 0;
  for (const auto& [key, item] : value.items()) {
    if (++shown > kMaxItems) return text + ", ...";
    text += (shown == 1 ? "" : ", ") + (value.is_object() ? key + " " : "") + value_text(item);
  }
  return value.is_array() ? "(" + text + ")" : text;
}

void add_lines(std::string& text, const std::string& name, const Json& value, std::size_t depth) {
  const bool is_list = value.is_array() && !value.empty() && value[0].is_structured();
  const std::string head = std::string(2 * depth, ' ') + name;
  if (value.is_object()) {
    text += head + ":\n";
    for (const auto& [key, member] : value.items()) add_lines(text, key, member, depth + 1);
  } else if (is_list) {
    for (std::size_t i = 0; i < std::min(value.size(), kMaxItems); ++i)
      text += fmt::format("{} {}: {}\n", head, i, value_text(value[i]));
    if (value.size() > kMaxItems)
      text += fmt::format("{}: {} more, see --json\n", head, value.size() - kMaxItems);
  } else {
    text += head + ": " + value_text(value) + "\n";
  }
}

}  // namespace

std::string_view name_of(proto::SegmentKind kind) noexcept {
  return publication::ending_of(kind).substr(1);
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

std::string table_of(const Json& segments) {
  if (segments.empty()) return "no session in shared memory\n";
  std::vector<Row> rows{kHead};
  std::transform(segments.begin(), segments.end(), std::back_inserter(rows), row_of);
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

std::string detail_of(const Json& session) {
  std::string text;
  for (const auto& [key, value] : session.items()) add_lines(text, key, value, 0);
  return text;
}

}  // namespace stillgrid::segment_inspect
