#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace stillgrid {

/// A force and its moment about the tool's origin.
struct Wrench {
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque_N_m = Eigen::Vector3d::Zero();

  Wrench& operator*=(double share) noexcept {
    force_N *= share;
    torque_N_m *= share;
    return *this;
  }
};

/// Shortens force and torque by one factor, so that neither is more than a force of limit_N makes
/// at the end of the lever; whether it had to. No driver declares a limit for torque.
/// Realtime: yes. Pre: finite; limit_N >= 0, lever_m > 0.
inline bool shorten(Wrench& wrench, double limit_N, double lever_m) noexcept {
  const double norm_N = std::max(wrench.force_N.norm(), wrench.torque_N_m.norm() / lever_m);
  if (!(norm_N > limit_N)) return false;
  wrench *= limit_N / norm_N;
  return true;
}

}  // namespace stillgrid
