#include "haptic_server/devices/trajectory_columns.hpp"

#include <algorithm>
#include <initializer_list>
#include <stdexcept>

#include "haptic_server/devices/number.hpp"

namespace stillgrid::devices {
namespace {

constexpr std::array<std::string_view, 3> kAxisNames = {"x_m", "y_m", "z_m"};

std::string_view trim(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t end = text.find(separator); end != std::string_view::npos;
       end = text.find(separator)) {
    parts.push_back(trim(text.substr(0, end)));
    text.remove_prefix(end + 1);
  }
  parts.push_back(trim(text));
  return parts;
}

std::optional<Column> find_column(const CsvRow& header, std::initializer_list<std::string> names) {
  std::optional<Column> found;
  for (std::size_t i = 0; i < header.fields.size(); ++i) {
    const std::string name(header.fields[i]);
    if (std::find(names.begin(), names.end(), name) == names.end()) continue;
    if (found) refuse_column(header, name, "given twice, as " + found->name + ": expected once");
    found = Column{name, i, 1.0, name.ends_with("_mm") ? 1000.0 : 1.0};
  }
  return found;
}

std::vector<Column> find_group(const CsvRow& header, std::initializer_list<std::string> names) {
  std::vector<Column> group;
  std::string missing;
  for (const std::string& name : names) {
    const auto column = find_column(header, {name});
    if (column) {
      group.push_back(*column);
    } else {
      missing = name;
    }
  }
  if (!group.empty() && !missing.empty()) {
    refuse_column(header, missing, "missing: expected beside " + group.front().name);
  }
  return group;
}

}  // namespace

void refuse_column(const CsvRow& row, const std::string& column, const std::string& fault) {
  throw std::runtime_error(row.file + ":" + std::to_string(row.line) + ": column " + column + ": " +
                           fault);
}

bool next_row(std::string_view& text, CsvRow& row) {
  for (std::size_t end = text.find('\n'); end != std::string_view::npos; end = text.find('\n')) {
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end + 1);
    ++row.line;
    if (trim(line).empty()) continue;
    row.fields = split(line, ',');
    return true;
  }
  return false;
}

TrajectoryColumns find_trajectory_columns(const CsvRow& header, const AxisMap& map) {
  TrajectoryColumns columns;
  columns.field_count = header.fields.size();
  const auto time = find_column(header, {"time_s", "t_s"});
  if (!time) refuse_column(header, "time_s", "missing: expected a header naming time_s or t_s");
  columns.time = *time;

  const bool is_mapped =
      std::any_of(map.begin(), map.end(), [](const auto& axis) { return axis.has_value(); });
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name(kAxisNames[axis]);
    if (is_mapped && !map[axis]) continue;
    auto column = is_mapped ? find_column(header, {map[axis]->column})
                            : find_column(header, {name, name + "m"});
    if (!column) {
      const std::string expected = is_mapped ? "by the map of " + name : "x_m, y_m, z_m (or _mm)";
      refuse_column(header, is_mapped ? map[axis]->column : name, "missing: expected " + expected);
    }
    if (is_mapped) {
      column->factor = map[axis]->factor;
      column->divisor = 1.0;
    }
    columns.position[axis] = *column;
  }
  columns.orientation = find_group(header, {"qx", "qy", "qz", "qw"});
  if (!is_mapped) columns.velocity = find_group(header, {"vx_m_s", "vy_m_s", "vz_m_s"});
  columns.force = find_group(header, {"fx_N", "fy_N", "fz_N"});
  return columns;
}

AxisMap parse_axis_map(std::string_view text) {
  const auto refuse_map = [text] {
    throw std::runtime_error("map: value '" + std::string(text) +
                             "': expected AXIS:COLUMN[*FACTOR] separated by ';', AXIS one of x_m, "
                             "y_m, z_m and given once");
  };
  AxisMap map;
  for (const std::string_view part : split(text, ';')) {
    const std::size_t colon = part.find(':');
    const std::size_t star = part.rfind('*');
    const auto* const name = std::find(kAxisNames.begin(), kAxisNames.end(), part.substr(0, colon));
    if (colon == std::string_view::npos || name == kAxisNames.end()) refuse_map();
    auto& axis = map[static_cast<std::size_t>(name - kAxisNames.begin())];
    const bool has_factor = star != std::string_view::npos && star > colon;
    const auto factor = has_factor ? parse_number(part.substr(star + 1)) : 1.0;
    const std::string_view column =
        part.substr(colon + 1, has_factor ? star - colon - 1 : std::string_view::npos);
    if (axis || !factor || column.empty()) refuse_map();
    axis = MappedColumn{std::string(column), *factor};
  }
  return map;
}

}  // namespace stillgrid::devices
