#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/tables/number_table.hpp"

namespace stillgrid::tables {

/// A column of the file, and what one of its units is in metres.
struct MappedColumn {
  std::string column;
  double factor = 1.0;
};

/// Which column stands for x, y and z. Without any, the file's own x_m, y_m and z_m do.
using AxisMap = std::array<std::optional<MappedColumn>, 3>;

/// Reads "AXIS:COLUMN[*FACTOR]", several separated by ';', such as
/// "x_m:slave_rad*0.075;z_m:height_mm*0.001". AXIS is x_m, y_m or z_m; no unit is guessed
/// from the column's name.
///
/// Throws std::runtime_error, one line naming the value and what is expected.
[[nodiscard]] AxisMap parse_axis_map(std::string_view text);

/// The columns of a recorded trajectory.
struct TrajectoryColumns {
  Column time;
  std::array<std::optional<Column>, 3> position;  // an axis left out by a map is empty
  std::vector<Column> orientation;                // qx, qy, qz, qw or none
  std::vector<Column> velocity;                   // three or none
  std::vector<Column> force;                      // three or none
};

/// Finds the columns in the table's header. Throws std::runtime_error as NumberTable, for a column
/// that is missing or given twice.
[[nodiscard]] TrajectoryColumns find_trajectory_columns(const NumberTable& table,
                                                        const AxisMap& map);

}  // namespace stillgrid::tables
