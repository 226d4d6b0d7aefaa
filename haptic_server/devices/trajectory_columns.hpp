#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace stillgrid::devices {

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

/// A line of a CSV file, cut into fields without their surrounding blanks.
struct CsvRow {
  std::string file;
  std::size_t line = 0;                  // counted from one
  std::vector<std::string_view> fields;  // views of the text given to next_row()
};

/// Moves on to the next line that is not blank and ends in a newline; false when none is
/// left. Takes what it read from the front of text.
bool next_row(std::string_view& text, CsvRow& row);

/// A column that is read: its place, and how its unit becomes metres.
struct Column {
  std::string name;
  std::size_t index = 0;
  double factor = 1.0;
  double divisor = 1.0;  // apart from factor: v / 1000 rounds once, v * 0.001 twice
};

/// The columns of a recorded trajectory.
struct TrajectoryColumns {
  std::size_t field_count = 0;
  Column time;
  std::array<std::optional<Column>, 3> position;  // an axis left out by a map is empty
  std::vector<Column> orientation;                // qx, qy, qz, qw or none
  std::vector<Column> velocity;                   // three or none
  std::vector<Column> force;                      // three or none
};

/// Finds the columns in the header line.
///
/// Throws std::runtime_error, as read_trajectory(), for a column that is missing or given
/// twice.
[[nodiscard]] TrajectoryColumns find_trajectory_columns(const CsvRow& header, const AxisMap& map);

/// Throws std::runtime_error "FILE:LINE: column NAME: FAULT".
[[noreturn]] void refuse_column(const CsvRow& row, const std::string& column,
                                const std::string& fault);

}  // namespace stillgrid::devices
