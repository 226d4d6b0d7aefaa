#include "tests/laboratory/path_file.hpp"

#include <unistd.h>

#include <atomic>
#include <fstream>
#include <limits>
#include <string>
#include <system_error>

#include "tests/laboratory/cannot_start.hpp"

namespace stillgrid::laboratory {
namespace {

std::filesystem::path unique_path() {
  static std::atomic<int> count = 0;
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(error);
  if (error) throw CannotStart("the temporary folder, $TMPDIR: " + error.message());
  return folder /
         ("stillgrid-path-" + std::to_string(::getpid()) + "-" + std::to_string(++count) + ".csv");
}

}  // namespace

PathFile::PathFile(const scene::DeviceFrame& frame, std::span<const PathPoint> points)
    : path_(unique_path()) {
  std::ofstream stream(path_);
  stream.precision(std::numeric_limits<double>::max_digits10);
  stream << "time_s,x_m,y_m,z_m\n";
  for (const PathPoint& point : points) {
    const Eigen::Vector3d device_m =
        frame.orientation.conjugate() * (point.position_m - frame.position_m) / frame.scale;
    stream << point.time_s << ',' << device_m.x() << ',' << device_m.y() << ',' << device_m.z()
           << '\n';
  }
  if (stream.flush()) return;
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
  throw CannotStart(path_.string() + ": cannot be written");
}

PathFile::~PathFile() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

}  // namespace stillgrid::laboratory
