#include "shared/tables/trajectory.hpp"

#include <cmath>
#include <cstddef>
#include <optional>

#include "shared/tables/number_table.hpp"

namespace stillgrid::tables {
namespace {

Eigen::Vector3d vector_at(const NumberTable& table, const std::vector<Column>& columns) {
  return {table.number(columns[0]), table.number(columns[1]), table.number(columns[2])};
}

Eigen::Vector3d position_at(const NumberTable& table, const TrajectoryColumns& columns,
                            const TrajectoryOptions& options) {
  Eigen::Vector3d position_m = options.offset_m;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& column = columns.position[axis];
    if (!column) continue;
    double& coordinate_m = position_m[static_cast<Eigen::Index>(axis)];
    coordinate_m += options.scale * table.number(*column);
    if (!(std::abs(coordinate_m) <= kLongest_m))
      table.refuse_value(*column, "a length of at most 1e6 m, scaled");
  }
  return position_m;
}

Eigen::Quaterniond orientation_at(const NumberTable& table, const std::vector<Column>& columns) {
  constexpr double kNormTolerance = 0.05;  // recordings round to a few digits
  const Eigen::Quaterniond q(table.number(columns[3]), table.number(columns[0]),
                             table.number(columns[1]), table.number(columns[2]));
  if (!(std::abs(q.norm() - 1.0) < kNormTolerance))
    table.refuse_value(columns[3], "a quaternion of norm one");
  return q.normalized();
}

/// The row's stamp after the first one, which first_s remembers.
double time_of(const NumberTable& table, const Column& column, std::optional<double>& first_s,
               const Trajectory& so_far) {
  const double stamp_s = table.number(column);
  if (!first_s) first_s = stamp_s;
  const double time_s = stamp_s - *first_s;
  if (!std::isfinite(time_s)) table.refuse_value(column, "a finite time since the first row");
  if (!so_far.time_s.empty() && time_s < so_far.time_s.back())
    table.refuse_value(column, "a time not before that of the row above");
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

void append_row(const NumberTable& table, const TrajectoryColumns& columns,
                const TrajectoryOptions& options, double time_s, Trajectory& trajectory) {
  if (!trajectory.time_s.empty() && trajectory.time_s.back() == time_s)
    drop_last_sample(trajectory);
  trajectory.time_s.push_back(time_s);
  trajectory.line.push_back(table.line());
  trajectory.position_m.push_back(position_at(table, columns, options));
  if (!columns.orientation.empty())
    trajectory.orientation.push_back(orientation_at(table, columns.orientation));
  if (!columns.velocity.empty())
    trajectory.velocity_m_s.emplace_back(options.scale * vector_at(table, columns.velocity));
  if (!columns.force.empty()) trajectory.force_N.push_back(vector_at(table, columns.force));
}

}  // namespace

Trajectory read_trajectory(const std::string& file, const TrajectoryOptions& options) {
  NumberTable table(file, "time_s, x_m, ...", LastLine::kMayBeCut);
  const TrajectoryColumns columns = find_trajectory_columns(table, options.map);
  Trajectory trajectory;
  trajectory.is_recording =
      table.find({"rendered_fx_N"}).has_value() || table.starts_with("# scene: ");
  std::optional<double> first_s;
  while (table.next())
    append_row(table, columns, options, time_of(table, columns.time, first_s, trajectory),
               trajectory);
  if (trajectory.time_s.empty())
    table.refuse_file("no whole row: expected at least one below the header");
  return trajectory;
}

}  // namespace stillgrid::tables
