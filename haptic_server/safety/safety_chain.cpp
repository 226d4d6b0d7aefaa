#include "haptic_server/safety/safety_chain.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "haptic_server/safety/slew_limit.hpp"

namespace stillgrid::safety {
namespace {

constexpr double kFade_s = 0.1;
constexpr double kStaleAfterPeriods = 1.5;
/// For every declared period. The scheduler delays a simulation at 1 kHz by several milliseconds,
/// which is no fault of it; a hand does not wait longer than a second for a world that may have
/// gone.
constexpr double kShortestPatience_s = 0.015, kLongestPatience_s = 1.0;

bool is_fresh(const SnapshotFreshness& snapshot) {
  const double patience_s = snapshot.goes_on ? kLongestPatience_s
                                             : std::clamp(kStaleAfterPeriods * snapshot.period_s,
                                                          kShortestPatience_s, kLongestPatience_s);
  return snapshot.exists && snapshot.writer_alive && snapshot.snapshot_age_s <= patience_s;
}

/// Along the rendered force: what slides at one depth neither takes nor gives. Slower than encoder
/// noise in the estimate, and than a hand that does anything.
bool is_at_rest(const SafetyInput& input, double lever_m) {
  constexpr double kAtRest_m_s = 0.02;
  const Wrench& rendered = input.rendered;
  const double given_J = input.elapsed_s * rendered.force_N.dot(input.velocity_m_s) +
                         rendered.torque_N_m.dot(input.motion.turned_rad);
  return std::abs(given_J) < kAtRest_m_s * input.elapsed_s * norm_N(rendered, lever_m);
}

void lead(double& share, bool upwards, double elapsed_s) {
  share = std::clamp(share + (upwards ? elapsed_s : -elapsed_s) / kFade_s, 0.0, 1.0);
}

}  // namespace

SafetyChain::SafetyChain(const SafetyLimits& limits)
    : limits_(limits),
      governor_(limits.stiffness_N_per_m),
      budget_(limits.continuous_force_N, limits.motor_time_constant_s),
      torque_budget_(limits.continuous_torque_N_m, limits.motor_time_constant_s) {
  assert(std::isfinite(limits.max_force_N) && limits.max_force_N > 0.0);
  assert(limits.lever_m > 0.0 && limits.period_s > 0.0);
  if (limits.passivity_mass_kg) passivity_control_.emplace(*limits.passivity_mass_kg);
}

void SafetyChain::cut() noexcept {
  commanded_ = {};
  ramp_share_ = 0.0;
}

bool SafetyChain::is_silent() const noexcept {
  return std::min(freshness_share_, ramp_share_) == 0.0 && commanded_.force_N.isZero(0.0) &&
         commanded_.torque_N_m.isZero(0.0);
}

/// How far snapshot and device are to be followed.
void SafetyChain::ramp(const SafetyInput& input, std::uint32_t& flags) noexcept {
  lead(freshness_share_, is_fresh(input.snapshot), input.elapsed_s);
  lead(ramp_share_, input.device_believed, input.elapsed_s);
  if (!input.device_believed) flags |= kFlagBadDevice;
  if (freshness_share_ < 1.0) flags |= kFlagFaded;
  if (ramp_share_ < 1.0) flags |= kFlagRamped;
}

/// The rendered force as far as each stage lets it through.
Wrench SafetyChain::limited(const SafetyInput& input, double energy_share,
                            std::uint32_t& flags) noexcept {
  Wrench next = input.rendered;
  double limit_N = limits_.max_force_N;
  const double lever_m = limits_.lever_m;
  const auto keep = [&](double share, std::uint32_t flag) {
    if (share < 1.0) flags |= flag;
    next *= share;
    limit_N *= share;
  };
  keep(std::min(freshness_share_, ramp_share_), 0);
  const double governed =
      governor_.share(input.stiffness_N_per_m, !commanded_.force_N.isZero(0.0), input.elapsed_s);
  if (governed < 1.0 && !(next.force_N.isZero(0.0) && next.torque_N_m.isZero(0.0)))
    flags |= kFlagStiffness;
  next *= governed;  // not the limit: a force at its limit has no stiffness
  if (const double budget_N = budget_.limit(limits_.max_force_N); budget_N < limit_N) {
    if (shorten(next, budget_N, lever_m)) flags |= kFlagBudget;
    limit_N = budget_N;
  }
  const double most_torque_N_m = lever_m * limits_.max_force_N;
  const double allowed_torque_N_m = torque_budget_.limit(most_torque_N_m);
  const double torque_N_m = next.torque_N_m.stableNorm();
  if (allowed_torque_N_m < most_torque_N_m && torque_N_m > allowed_torque_N_m) {
    next *= allowed_torque_N_m / torque_N_m;
    flags |= kFlagBudget;
  }
  keep(workspace_share(limits_.workspace, input.device_m), kFlagWorkspace);
  if (limit_drive(next.force_N, input.velocity_m_s, limits_.max_speed_m_s)) flags |= kFlagSpeed;
  const auto clamp = [&] {
    if (shorten(next, limit_N, lever_m)) flags |= kFlagClamped;
  };
  clamp();
  // One control of energy at a time: what both take back is taken twice, and the wall sinks.
  if (!passivity_control_ && energy_share < 1.0 &&
      limit_norm(next, energy_share * norm_N(input.rendered, lever_m), lever_m))
    flags |= kFlagEnergy;
  if (passivity_control_ && input.snapshot.exists)
    next.force_N += passivity_control_->damp(energy_, input.given_by_scenes_J, input.motion,
                                             input.elapsed_s, flags);
  clamp();
  return next;
}

Wrench SafetyChain::apply(const SafetyInput& input, std::uint32_t& flags) noexcept {
  observe(energy_, commanded_, input.motion);
  contact_.observe(commanded_, input.motion, limits_.lever_m);
  budget_.spend(commanded_.force_N.norm(), input.elapsed_s);
  torque_budget_.spend(commanded_.torque_N_m.norm(), input.elapsed_s);
  const bool is_number = std::isfinite(norm_N(input.rendered, limits_.lever_m));
  const double energy_share =
      is_number ? contact_.share(input.rendered, input.stiffness_N_per_m,
                                 is_at_rest(input, limits_.lever_m), input.elapsed_s)
                : contact_.skip();
  if (input.elapsed_s >= limits_.stall_s) {
    cut();
    flags |= kFlagStalled | kFlagRamped;
    return commanded_;
  }
  if (!input.device_ready) {
    cut();
    flags |= kFlagRamped;
    return commanded_;
  }

  ramp(input, flags);
  Wrench next;
  if (is_number)
    next = limited(input, energy_share, flags);
  else
    flags |= kFlagRejected;
  const double granted_s = std::clamp(input.since_command_s, 0.0, limits_.period_s);
  if (limit_slew(next, commanded_, limits_.max_slew_N_per_ms * granted_s * 1e3, limits_.lever_m))
    flags |= kFlagSlewed;
  commanded_ = next;
  return commanded_;
}

}  // namespace stillgrid::safety
