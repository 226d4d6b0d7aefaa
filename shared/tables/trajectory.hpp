#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <string>
#include <vector>

#include "shared/tables/trajectory_columns.hpp"

namespace stillgrid::tables {

/// A motion as it was recorded, one sample a row, in the recording's frame after scale and
/// offset.
///
/// Invariants: at least one sample; time_s grows strictly from zero; all values finite. Every array
/// is as long as time_s, or empty if the recording lacks its columns.
struct Trajectory {
  std::vector<double> time_s;
  std::vector<std::size_t> line;  // in the file, counted from one; empty if not read
  std::vector<Eigen::Vector3d> position_m;
  std::vector<Eigen::Quaterniond> orientation;  // unit
  std::vector<Eigen::Vector3d> velocity_m_s;
  std::vector<Eigen::Vector3d> force_N;
  bool is_recording = false;  // haptic_server wrote it, in the scene's frame
};

/// Changes recorded positions to scale * recorded + offset.
///
/// Velocities are scaled with them, forces are not. Axes that a map leaves out are zero before the
/// offset. A map ignores velocity columns, for they belong to another point.
struct TrajectoryOptions {
  double scale = 1.0;
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();
  AxisMap map;
};

/// Reads a recorded trajectory, the CSV of docs/formats.md. A row counts once its newline is there,
/// so that a file cut off at any byte is read up to its last whole row. The last of rows with
/// equal stamps counts.
///
/// Throws std::runtime_error as NumberTable, for a bad row or header, for a file without a whole
/// row, and for one that cannot be read.
[[nodiscard]] Trajectory read_trajectory(const std::string& file,
                                         const TrajectoryOptions& options = {});

}  // namespace stillgrid::tables
