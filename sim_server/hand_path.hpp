#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <vector>

#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// Where a hand holds the tool, in the scene.
struct HandPose {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
};

/// The path of a hand, from a file as the device `replay` reads it: `time_s,x_m,y_m,z_m` in the
/// device's frame, and `qx,qy,qz,qw` if the tool turns; other columns are ignored. Time starts at
/// zero.
class HandPath {
 public:
  /// device: where it stands in the scene. Throws std::runtime_error, one line with file, line and
  /// column, for what is no such file.
  HandPath(const std::filesystem::path& file, const scene::DeviceFrame& device);

  [[nodiscard]] double duration_s() const noexcept { return time_s_.back(); }
  /// Evenly from row to row; beyond both ends it stands still.
  [[nodiscard]] HandPose at(double time_s) const noexcept;

 private:
  std::vector<double> time_s_;  // grow strictly, the first 0
  std::vector<HandPose> poses_;
};

}  // namespace stillgrid::sim_server
