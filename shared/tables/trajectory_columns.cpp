#include "shared/tables/trajectory_columns.hpp"

#include <algorithm>
#include <stdexcept>

#include "shared/files/number_text.hpp"

namespace stillgrid::tables {
namespace {

constexpr std::array<std::string_view, 3> kAxisNames = {"x_m", "y_m", "z_m"};

}  // namespace

TrajectoryColumns find_trajectory_columns(const NumberTable& table, const AxisMap& map) {
  TrajectoryColumns columns;
  columns.time = table.require({"time_s", "t_s"}, "a header naming time_s or t_s");
  const bool is_mapped =
      std::any_of(map.begin(), map.end(), [](const auto& axis) { return axis.has_value(); });
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name(kAxisNames[axis]);
    if (!is_mapped) {
      columns.position[axis] = table.require({name}, "x_m, y_m, z_m (or _mm)");
    } else if (map[axis]) {
      Column column = table.require({map[axis]->column}, "by the map of " + name);
      column.factor = map[axis]->factor;
      column.divisor = 1.0;
      columns.position[axis] = column;
    }
  }
  columns.orientation = table.find_group({"qx", "qy", "qz", "qw"});
  if (!is_mapped) columns.velocity = table.find_group({"vx_m_s", "vy_m_s", "vz_m_s"});
  columns.force = table.find_group({"fx_N", "fy_N", "fz_N"});
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
    const auto factor = has_factor ? files::finite_number(part.substr(star + 1)) : 1.0;
    const std::string_view column =
        part.substr(colon + 1, has_factor ? star - colon - 1 : std::string_view::npos);
    if (axis || !factor || column.empty()) refuse_map();
    axis = MappedColumn{std::string(column), *factor};
  }
  return map;
}

}  // namespace stillgrid::tables
