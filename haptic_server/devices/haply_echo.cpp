#include "haptic_server/devices/haply_echo.hpp"

#include <algorithm>

namespace stillgrid::devices {

void HaplyEcho::sent(const Eigen::Vector3d& force_N) noexcept {
  newest_ = (newest_ + 1) % sent_N_.size();
  sent_N_[newest_] = force_N;
}

HaplyEcho::Verdict HaplyEcho::heard(const Eigen::Vector3d& force_N) noexcept {
  Eigen::Vector3d low_N = sent_N_[0];
  Eigen::Vector3d high_N = sent_N_[0];
  double greatest_N = 0.0;
  for (const Eigen::Vector3d& one_N : sent_N_) {
    low_N = low_N.cwiseMin(one_N);
    high_N = high_N.cwiseMax(one_N);
    greatest_N = std::max(greatest_N, one_N.norm());
  }
  const double heard_norm_N = force_N.norm();
  if (greatest_N <= kTolerance_N && heard_norm_N <= kTolerance_N) return Verdict::kAgrees;
  const double tolerance_N = kTolerance_N + kTolerance * greatest_N;
  if (((low_N - force_N).array() <= tolerance_N).all() &&
      ((force_N - high_N).array() <= tolerance_N).all()) {
    has_confirmed_ = has_confirmed_ || heard_norm_N > kTolerance_N;
    if (has_confirmed_)
      differing_ = 0;  // that there is no force a service that ignores us tells too
    return Verdict::kAgrees;
  }
  if (++differing_ < kPatience) return Verdict::kAgrees;
  return has_confirmed_ || heard_norm_N > kTolerance_N ? Verdict::kDiffers : Verdict::kIgnored;
}

}  // namespace stillgrid::devices
