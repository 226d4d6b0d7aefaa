#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "haptic_server/safety/safety_chain.hpp"

namespace stillgrid::safety {

/// From a tick to the next.
inline constexpr double kTick_s = 1e-3;

/// A fresh snapshot, a believed device, and this force.
inline SafetyInput push(double x_N, double y_N = 0.0, double z_N = 0.0) {
  return {
      .rendered = {{x_N, y_N, z_N}, Eigen::Vector3d::Zero()},
      .snapshot = {.exists = true, .snapshot_age_s = 0.0, .period_s = 0.033, .writer_alive = true},
      .elapsed_s = kTick_s};
}

/// The same, of a simulation that has died.
inline SafetyInput dead(SafetyInput input) {
  input.snapshot.writer_alive = false;
  return input;
}

/// What a tick commands, and why.
struct Commanded {
  Wrench wrench;
  std::uint32_t flags = 0;
  [[nodiscard]] double x_N() const { return wrench.force_N.x(); }
};

inline Commanded tick(SafetyChain& chain, const SafetyInput& input) {
  Commanded commanded;
  commanded.wrench = chain.apply(input, commanded.flags);
  return commanded;
}

inline Commanded after(SafetyChain& chain, const SafetyInput& input, int ticks) {
  Commanded commanded;
  for (int i = 0; i < ticks; ++i) commanded = tick(chain, input);
  return commanded;
}

/// A chain past its ramp, holding nothing.
inline SafetyChain warmed_up(const SafetyLimits& limits) {
  SafetyChain chain(limits);
  (void)after(chain, push(0.0), 101);
  return chain;
}

}  // namespace stillgrid::safety
