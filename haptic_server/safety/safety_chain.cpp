#include "haptic_server/safety/safety_chain.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace stillgrid {
namespace {

constexpr double kFade_s = 0.1;
constexpr double kStaleAfterPeriods = 1.5;

bool is_fresh(const ImageFreshness& image) {
  return image.exists && image.writer_alive &&
         image.image_age_s <= kStaleAfterPeriods * image.period_s;
}

void lead(double& share, bool upwards, double elapsed_s) {
  share = std::clamp(share + (upwards ? elapsed_s : -elapsed_s) / kFade_s, 0.0, 1.0);
}

}  // namespace

SafetyChain::SafetyChain(const SafetyLimits& limits)
    : limits_(limits),
      governor_(limits.stiffness_N_m),
      budget_(limits.continuous_force_N, limits.motor_time_constant_s) {
  assert(std::isfinite(limits.max_force_N) && limits.max_force_N > 0.0);
  if (limits.passivity_mass_kg) passivity_control_.emplace(*limits.passivity_mass_kg);
}

void SafetyChain::cut() noexcept {
  told_ = {};
  ramp_share_ = 0.0;
}

bool SafetyChain::is_silent() const noexcept {
  return std::min(image_share_, ramp_share_) == 0.0 && told_.force_N.isZero(0.0) &&
         told_.torque_N_m.isZero(0.0);
}

/// How far image and device are to be followed.
void SafetyChain::ramp(const SafetyInput& input, std::uint32_t& flags) noexcept {
  lead(image_share_, is_fresh(input.image), input.elapsed_s);
  lead(ramp_share_, input.device_believed, input.elapsed_s);
  if (!input.device_believed) flags |= kFlagBadDevice;
  if (image_share_ < 1.0) flags |= kFlagFaded;
  if (ramp_share_ < 1.0) flags |= kFlagRamped;
}

Wrench SafetyChain::apply(const SafetyInput& input, std::uint32_t& flags) noexcept {
  observe(energy_, told_, input.motion);
  budget_.spend(told_.force_N.norm(), input.elapsed_s);
  if (input.elapsed_s >= limits_.stall_s) {
    cut();
    flags |= kFlagStalled | kFlagRamped;
    return told_;
  }

  ramp(input, flags);
  Wrench next = input.rendered;
  double limit_N = limits_.max_force_N;
  if (!next.force_N.allFinite() || !next.torque_N_m.allFinite()) {
    next = {};
    flags |= kFlagRejected;
  }
  const auto keep = [&](double share, std::uint32_t flag) {
    if (share < 1.0) flags |= flag;
    next *= share;
    limit_N *= share;
  };
  keep(std::min(image_share_, ramp_share_), 0);
  const double governed =
      governor_.share(input.stiffness_N_m, !told_.force_N.isZero(0.0), input.elapsed_s);
  if (governed < 1.0 && !(next.force_N.isZero(0.0) && next.torque_N_m.isZero(0.0)))
    flags |= kFlagStiffness;
  next *= governed;  // not the limit: a force at its limit has no stiffness
  if (const double budget_N = budget_.limit_N(limits_.max_force_N); budget_N < limit_N) {
    if (shorten(next, budget_N, input.lever_m)) flags |= kFlagBudget;
    limit_N = budget_N;
  }
  keep(workspace_share(limits_.workspace, input.device_m), kFlagWorkspace);
  if (limit_drive(next.force_N, input.velocity_m_s, limits_.max_speed_m_s)) flags |= kFlagSpeed;
  if (passivity_control_ && input.image.exists)
    next.force_N += passivity_control_->damp(energy_, input.motion, input.elapsed_s, flags);
  if (shorten(next, limit_N, input.lever_m)) flags |= kFlagClamped;

  Wrench change{next.force_N - told_.force_N, next.torque_N_m - told_.torque_N_m};
  if (shorten(change, limits_.max_slew_N_per_ms * input.elapsed_s * 1e3, input.lever_m)) {
    next = {told_.force_N + change.force_N, told_.torque_N_m + change.torque_N_m};
    flags |= kFlagSlewed;
  }
  told_ = next;
  return told_;
}

double least_slew_N_per_ms(double max_force_N) noexcept {
  return max_force_N / (kFade_s * 1e3);
}

}  // namespace stillgrid
