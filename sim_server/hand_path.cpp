#include "sim_server/hand_path.hpp"

#include <algorithm>
#include <cstddef>
#include <stdexcept>

#include "shared/tables/trajectory.hpp"

namespace stillgrid::sim_server {

HandPath::HandPath(const std::filesystem::path& file, const scene::DeviceFrame& device) {
  const tables::Trajectory recorded = tables::read_trajectory(file.string());
  if (recorded.is_recording)
    throw std::runtime_error(file.string() +
                             ": a recording of haptic_server, which is in the scene's frame: "
                             "expected the path of a device");
  if (recorded.time_s.size() < 2)
    throw std::runtime_error(file.string() + ": one row: expected two at least");
  time_s_ = recorded.time_s;
  for (std::size_t i = 0; i < time_s_.size(); ++i)
    poses_.push_back(
        {device.position_m + device.scale * (device.orientation * recorded.position_m[i]),
         recorded.orientation.empty()
             ? Eigen::Quaterniond::Identity()
             : (device.orientation * recorded.orientation[i]).normalized()});
}

HandPose HandPath::at(double time_s) const noexcept {
  const auto after = std::upper_bound(time_s_.begin(), time_s_.end(), time_s);
  if (after == time_s_.begin()) return poses_.front();
  if (after == time_s_.end()) return poses_.back();
  const auto i = static_cast<std::size_t>(after - time_s_.begin());
  const double share = (time_s - time_s_[i - 1]) / (time_s_[i] - time_s_[i - 1]);
  const HandPose &from = poses_[i - 1], &to = poses_[i];
  return {from.position_m + share * (to.position_m - from.position_m),
          from.orientation.slerp(share, to.orientation)};
}

}  // namespace stillgrid::sim_server
