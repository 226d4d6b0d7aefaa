#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <span>

#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::laboratory {

/// Where a tool is to be, in the scene.
struct PathPoint {
  double time_s = 0.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
};

/// A trajectory for a device, in the temporary folder, that goes when its user does.
class PathFile {
 public:
  /// frame: of the scene, from which the points are taken back to the device. Throws CannotStart if
  /// there is no temporary folder, or no room in it.
  PathFile(const scene::DeviceFrame& frame, std::span<const PathPoint> points);
  ~PathFile();
  PathFile(const PathFile&) = delete;
  PathFile& operator=(const PathFile&) = delete;
  PathFile(PathFile&&) = delete;
  PathFile& operator=(PathFile&&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace stillgrid::laboratory
