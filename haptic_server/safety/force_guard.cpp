#include "haptic_server/safety/force_guard.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace stillgrid {
namespace {

constexpr double kFade_s = 0.1;
constexpr double kStaleAfterPeriods = 1.5;

/// Shortens v to a norm of at most `limit`; whether it had to.
bool shorten(Eigen::Vector3d& v, double limit) {
  assert(std::isfinite(limit) && limit >= 0.0);
  const double norm = v.norm();
  if (!(norm > limit)) return false;
  v *= limit / norm;
  return true;
}

}  // namespace

Eigen::Vector3d ForceGuard::apply(const Eigen::Vector3d& rendered_N,
                                  const ImageFreshness& freshness, double tick_s,
                                  std::uint32_t& flags) noexcept {
  Eigen::Vector3d force_N = rendered_N;
  if (!force_N.allFinite()) {
    force_N.setZero();
    flags |= kFlagRejected;
  }
  if (shorten(force_N, limits_.max_force_N)) flags |= kFlagClamped;
  if (limits_.max_slew_N_per_ms) {
    Eigen::Vector3d change_N = force_N - last_N_;
    if (shorten(change_N, *limits_.max_slew_N_per_ms * tick_s * 1e3)) {
      force_N = last_N_ + change_N;
      flags |= kFlagSlewed;
    }
  }
  last_N_ = force_N;

  // After the slew limit, which would else hold a dead simulation's force for longer than the fade.
  const bool fresh = freshness.exists && freshness.writer_alive &&
                     freshness.image_age_s <= kStaleAfterPeriods * freshness.period_s;
  gain_ = std::clamp(gain_ + (fresh ? tick_s : -tick_s) / kFade_s, 0.0, 1.0);
  if (gain_ < 1.0) flags |= kFlagFaded;
  return gain_ * force_N;
}

}  // namespace stillgrid
