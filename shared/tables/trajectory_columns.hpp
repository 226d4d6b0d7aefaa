#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/tables/number_table.hpp"

namespace stillgrid::tables {

/// A column of the file, and the length of its unit in metres.
struct MappedColumn {
  std::string column;
  double factor = 1.0;
};

/// The columns that replace x_m, y_m and z_m. Empty: the file's own.
using AxisMap = std::array<std::optional<MappedColumn>, 3>;

/// Reads "AXIS:COLUMN[*FACTOR]", several separated by ';', such as
/// "x_m:slave_rad*0.075;z_m:height_mm*0.001". AXIS is x_m, y_m or z_m; no unit is guessed
/// from the column's name.
///
/// Throws std::runtime_error: one line with the value and the expected form.
[[nodiscard]] AxisMap parse_axis_map(std::string_view text);

/// The columns of a recorded trajectory.
struct TrajectoryColumns {
  Column time;
  std::array<std::optional<Column>, 3> position;  // an axis left out by a map is empty
  std::vector<Column> orientation;                // qx, qy, qz, qw, or empty
  std::vector<Column> velocity;                   // three, or empty
  std::vector<Column> force;                      // three, or empty
};

/// Finds the columns in the table's header. Throws std::runtime_error as NumberTable, for a column
/// that is missing or given twice.
[[nodiscard]] TrajectoryColumns find_trajectory_columns(const NumberTable& table,
                                                        const AxisMap& map);

}  // namespace stillgrid::tables
