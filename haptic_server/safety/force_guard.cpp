#include "haptic_server/safety/force_guard.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace stillgrid {
namespace {

constexpr double kFade_s = 0.1;
constexpr double kStaleAfterPeriods = 1.5;

/// Shortens force and torque alike, so that neither is more than a force of `limit_N` at the end of
/// the lever; whether it had to.
bool shorten(Wrench& wrench, double limit_N, double lever_m) {
  assert(std::isfinite(limit_N) && limit_N >= 0.0 && lever_m > 0.0);
  const double norm = std::max(wrench.force_N.norm(), wrench.torque_N_m.norm() / lever_m);
  if (!(norm > limit_N)) return false;
  wrench.force_N *= limit_N / norm;
  wrench.torque_N_m *= limit_N / norm;
  return true;
}

}  // namespace

Wrench ForceGuard::apply(const Wrench& rendered, double lever_m, const ImageFreshness& freshness,
                         double tick_s, std::uint32_t& flags) noexcept {
  Wrench told = rendered;
  if (!told.force_N.allFinite() || !told.torque_N_m.allFinite()) {
    told = {};
    flags |= kFlagRejected;
  }
  if (shorten(told, limits_.max_force_N, lever_m)) flags |= kFlagClamped;
  if (limits_.max_slew_N_per_ms) {
    Wrench change{told.force_N - last_.force_N, told.torque_N_m - last_.torque_N_m};
    if (shorten(change, *limits_.max_slew_N_per_ms * tick_s * 1e3, lever_m)) {
      told = {last_.force_N + change.force_N, last_.torque_N_m + change.torque_N_m};
      flags |= kFlagSlewed;
    }
  }
  last_ = told;

  // After the slew limit, which would else hold a dead simulation's force for longer than the fade.
  const bool fresh = freshness.exists && freshness.writer_alive &&
                     freshness.image_age_s <= kStaleAfterPeriods * freshness.period_s;
  gain_ = std::clamp(gain_ + (fresh ? tick_s : -tick_s) / kFade_s, 0.0, 1.0);
  if (gain_ < 1.0) flags |= kFlagFaded;
  return {gain_ * told.force_N, gain_ * told.torque_N_m};
}

}  // namespace stillgrid
