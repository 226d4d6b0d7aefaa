#include "haptic_server/devices/spacemouse_motion.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid::devices {
namespace {

/// Three of the counts as a share of full deflection, device axes, its norm at most one.
Eigen::Vector3d deflection(int right, int up, int away, const SpacemouseSettings& settings) {
  const Eigen::Vector3d share =
      Eigen::Vector3d(Eigen::Vector3i(right, away, up).cast<double>()) / settings.full_scale;
  const double norm = share.norm();
  if (norm <= settings.dead_zone) return Eigen::Vector3d::Zero();
  const double beyond = (std::min(norm, 1.0) - settings.dead_zone) / (1.0 - settings.dead_zone);
  return share * (beyond / norm);
}

}  // namespace

void steer(SteeredPose& pose, const CapCounts& counts, const SpacemouseSettings& settings,
           double duration_s) noexcept {
  const Eigen::Vector3d push = deflection(counts[0], counts[1], counts[2], settings);
  pose.position_m += settings.speed_m_s * duration_s * push;
  pose.position_m = pose.position_m.cwiseMax(-settings.range_m).cwiseMin(settings.range_m);

  const Eigen::Vector3d twist = deflection(counts[3], counts[4], counts[5], settings);
  const double angle_rad = settings.rotation_rad_s * duration_s * twist.norm();
  if (angle_rad == 0.0) return;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle_rad, twist.normalized()));
  pose.orientation = (turn * pose.orientation).normalized();
}

}  // namespace stillgrid::devices
