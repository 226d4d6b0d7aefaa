#include "haptic_server/devices/trajectory.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "haptic_server/devices/number.hpp"
#include "shared/files/text_file.hpp"

namespace stillgrid::devices {
namespace {

[[noreturn]] void refuse_value(const CsvRow& row, const std::string& column, std::string_view value,
                               const std::string& expected) {
  constexpr std::size_t kLongestQuote = 40;
  refuse_column(
      row, column,
      "value '" + std::string(value.substr(0, kLongestQuote)) + "': expected " + expected);
}

[[noreturn]] void refuse_value(const CsvRow& row, const Column& column,
                               const std::string& expected) {
  refuse_value(row, column.name, row.fields[column.index], expected);
}

double number_at(const CsvRow& row, const Column& column) {
  const auto value = parse_number(row.fields[column.index]);
  if (!value) refuse_value(row, column, "a finite number");
  return *value * column.factor / column.divisor;
}

Eigen::Vector3d vector_at(const CsvRow& row, const std::vector<Column>& columns) {
  return {number_at(row, columns[0]), number_at(row, columns[1]), number_at(row, columns[2])};
}

Eigen::Vector3d position_at(const CsvRow& row, const TrajectoryColumns& columns,
                            const TrajectoryOptions& options) {
  Eigen::Vector3d position_m = options.offset_m;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& column = columns.position[axis];
    if (!column) continue;
    double& coordinate_m = position_m[static_cast<Eigen::Index>(axis)];
    coordinate_m += options.scale * number_at(row, *column);
    if (!std::isfinite(coordinate_m)) refuse_value(row, *column, "a finite length, scaled");
  }
  return position_m;
}

Eigen::Quaterniond orientation_at(const CsvRow& row, const std::vector<Column>& columns) {
  constexpr double kNormTolerance = 0.05;  // recordings round to a few digits
  const Eigen::Quaterniond q(number_at(row, columns[3]), number_at(row, columns[0]),
                             number_at(row, columns[1]), number_at(row, columns[2]));
  if (!(std::abs(q.norm() - 1.0) < kNormTolerance)) {
    refuse_value(row, columns[3], "a quaternion of norm one");
  }
  return q.normalized();
}

/// The row's stamp after the first one, which first_s remembers.
double time_of(const CsvRow& row, const TrajectoryColumns& columns, std::optional<double>& first_s,
               const Trajectory& so_far) {
  const double stamp_s = number_at(row, columns.time);
  if (!first_s) first_s = stamp_s;
  const double time_s = stamp_s - *first_s;
  if (!std::isfinite(time_s)) refuse_value(row, columns.time, "a finite time since the first row");
  if (!so_far.time_s.empty() && time_s < so_far.time_s.back()) {
    refuse_value(row, columns.time, "a time not before that of the row above");
  }
  return time_s;
}

void drop_last_sample(Trajectory& trajectory) {
  trajectory.time_s.pop_back();
  trajectory.line.pop_back();
  trajectory.position_m.pop_back();
  if (!trajectory.orientation.empty()) trajectory.orientation.pop_back();
  if (!trajectory.velocity_m_s.empty()) trajectory.velocity_m_s.pop_back();
  if (!trajectory.force_N.empty()) trajectory.force_N.pop_back();
}

void append_row(const CsvRow& row, const TrajectoryColumns& columns,
                const TrajectoryOptions& options, double time_s, Trajectory& trajectory) {
  if (!trajectory.time_s.empty() && trajectory.time_s.back() == time_s) {
    drop_last_sample(trajectory);
  }
  trajectory.time_s.push_back(time_s);
  trajectory.line.push_back(row.line);
  trajectory.position_m.push_back(position_at(row, columns, options));
  if (!columns.orientation.empty()) {
    trajectory.orientation.push_back(orientation_at(row, columns.orientation));
  }
  if (!columns.velocity.empty()) {
    trajectory.velocity_m_s.emplace_back(options.scale * vector_at(row, columns.velocity));
  }
  if (!columns.force.empty()) trajectory.force_N.push_back(vector_at(row, columns.force));
}

}  // namespace

Trajectory read_trajectory(const std::string& file, const TrajectoryOptions& options) {
  constexpr std::uintmax_t kMost = 1024 * files::kMiB;
  const std::string content = files::read_text(file, kMost);
  std::string_view text = content;
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // as some editors begin UTF-8
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  CsvRow row{file, 0, {}};
  bool has_header = next_row(text, row);
  while (has_header && row.fields.front().starts_with('#')) has_header = next_row(text, row);
  if (!has_header) {
    throw std::runtime_error(file + ": no whole header line: expected time_s, x_m, ...");
  }

  const TrajectoryColumns columns = find_trajectory_columns(row, options.map);
  Trajectory trajectory;
  std::optional<double> first_s;
  while (next_row(text, row)) {
    if (row.fields.size() != columns.field_count) {
      refuse_value(row, columns.time.name, row.fields.front(),
                   "a row of " + std::to_string(columns.field_count) + " fields, not " +
                       std::to_string(row.fields.size()));
    }
    const double time_s = time_of(row, columns, first_s, trajectory);
    append_row(row, columns, options, time_s, trajectory);
  }
  if (trajectory.time_s.empty()) {
    throw std::runtime_error(file + ": no whole row: expected at least one below the header");
  }
  return trajectory;
}

}  // namespace stillgrid::devices
