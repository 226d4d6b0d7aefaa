#pragma once

#include <algorithm>
#include <cmath>

#include "haptic_server/safety/wrench.hpp"

namespace stillgrid::safety {

/// Shortens a wrench so that it grows and turns by no more than step_N since the last one; whether
/// it had to.
///
/// Its norm may fall freely: a force that lags behind a hand which leaves would push it. It keeps
/// its direction, for a force across the rendered one makes energy: a turn that is too fast costs
/// norm instead, which then grows again. Norms: of the force and the torque over lever_m as one
/// vector of six. Realtime: yes. Pre: finite; step_N >= 0, lever_m > 0.
inline bool limit_slew(Wrench& next, const Wrench& last, double step_N, double lever_m) noexcept {
  const double wanted_N = norm_N(next, lever_m), last_N = norm_N(last, lever_m);
  if (!(wanted_N > 0.0)) return false;
  const double cosine =
      last_N > 0.0 ? std::clamp(dot_N2(next, last, lever_m) / wanted_N / last_N, -1.0, 1.0) : 1.0;
  const double chord = std::sqrt(2.0 * (1.0 - cosine));  // between the directions
  const double across_N = last_N * std::sqrt(1.0 - cosine * cosine);
  const double most_N =
      last_N * chord > step_N
          ? step_N / chord
          : last_N * cosine + std::sqrt(std::max(0.0, step_N * step_N - across_N * across_N));
  if (!(wanted_N > most_N)) return false;
  next *= most_N / wanted_N;
  return true;
}

}  // namespace stillgrid::safety
