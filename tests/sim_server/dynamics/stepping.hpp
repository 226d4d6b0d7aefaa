#pragma once

#include <optional>

#include "sim_server/dynamics/step/simulation.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define STILLGRID_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define STILLGRID_SANITIZED 1
#endif
#endif

namespace stillgrid::dynamics {

/// Into what ten minutes are cut with a sanitizer, which sees the same code in one.
#ifdef STILLGRID_SANITIZED
inline constexpr int kCut = 10;
#else
inline constexpr int kCut = 1;
#endif

[[nodiscard]] inline std::optional<ToolSample> no_tool() {
  return std::nullopt;
}

/// Steps without a tool; whether every step converged.
[[nodiscard]] inline bool advance(Simulation& simulation, double step_s, int steps) {
  bool converged = true;
  for (int i = 0; i < steps; ++i)
    converged = simulation.step(step_s, no_tool).solve.converged && converged;
  return converged;
}

}  // namespace stillgrid::dynamics
