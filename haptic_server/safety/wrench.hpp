#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace stillgrid::safety {

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

/// Inner product and norm of wrenches as vectors of six, the torque's part over the lever: forces.
/// Realtime: yes. Pre: lever_m > 0.
inline double dot_N2(const Wrench& a, const Wrench& b, double lever_m) noexcept {
  return a.force_N.dot(b.force_N) + (a.torque_N_m / lever_m).dot(b.torque_N_m / lever_m);
}
inline double norm_N(const Wrench& wrench, double lever_m) noexcept {
  return std::hypot(wrench.force_N.stableNorm(), wrench.torque_N_m.stableNorm() / lever_m);
}

/// Shortens a wrench to a norm as above; whether it had to. Realtime: yes. Pre: finite.
inline bool limit_norm(Wrench& wrench, double limit_N, double lever_m) noexcept {
  const double own_N = norm_N(wrench, lever_m);
  if (!(own_N > limit_N)) return false;
  wrench *= limit_N / own_N;
  return true;
}

/// Shortens force and torque by one factor, so that neither is more than a force of limit_N makes
/// at the end of the lever; whether it had to. One factor: a force and a torque shortened apart
/// would give energy to who presses with one and leaves by the other. Realtime: yes. Pre: finite;
/// limit_N >= 0, lever_m > 0.
inline bool shorten(Wrench& wrench, double limit_N, double lever_m) noexcept {
  const double greater_N =
      std::max(wrench.force_N.stableNorm(), wrench.torque_N_m.stableNorm() / lever_m);
  if (!(greater_N > limit_N)) return false;
  wrench *= limit_N / greater_N;
  return true;
}

}  // namespace stillgrid::safety
