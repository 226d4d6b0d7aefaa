#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "haptic_server/safety/wrench.hpp"

namespace stillgrid::safety {

/// Where a device may be told a force, device frame. An axis with min >= max has no edge.
struct Workspace {
  Eigen::Vector3d min_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d max_m = Eigen::Vector3d::Zero();
};

/// The share of the force to keep at a place: all of it inside, less and less over the last 5 mm,
/// or the last quarter of an axis that is shorter than 20 mm; none at the edge and beyond, where
/// encoders and linkage are not what the maker promised. Realtime: yes.
[[nodiscard]] inline double workspace_share(const Workspace& workspace,
                                            const Eigen::Vector3d& position_m) noexcept {
  constexpr double kMargin_m = 0.005;
  double share = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double extent_m = workspace.max_m[axis] - workspace.min_m[axis];
    if (!(extent_m > 0.0)) continue;
    const double inside_m = std::min(position_m[axis] - workspace.min_m[axis],
                                     workspace.max_m[axis] - position_m[axis]);
    const double margin_m = std::min(kMargin_m, 0.25 * extent_m);
    share = inside_m > 0.0 ? std::min(share, inside_m / margin_m) : 0.0;
    if (share == 0.0) break;
  }
  return share;
}

/// Takes away what drives a motion that is too fast: the part of the force along the velocity, all
/// of it from half as fast again as the limit on. What resists the motion stays. Whether anything
/// was taken. Realtime: yes. Pre: limit_m_s > 0.
inline bool limit_drive(Eigen::Vector3d& force_N, const Eigen::Vector3d& velocity_m_s,
                        double limit_m_s) noexcept {
  const double speed_m_s = velocity_m_s.norm();
  if (!(speed_m_s > limit_m_s)) return false;
  const Eigen::Vector3d along = velocity_m_s / speed_m_s;
  const double drive_N = force_N.dot(along);
  if (!(drive_N > 0.0)) return false;
  force_N -= std::min(1.0, 2.0 * (speed_m_s / limit_m_s - 1.0)) * drive_N * along;
  return true;
}

}  // namespace stillgrid::safety
