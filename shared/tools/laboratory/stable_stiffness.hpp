#pragma once

#include <functional>
#include <optional>
#include <span>

#include "haptic_server/recording/recorder.hpp"

namespace stillgrid::laboratory {

/// When a run counts as oscillating: metric 6 of the laboratory.
struct Oscillation {
  double window_s = 0.5;         // the last of the run
  double limit_m = 4.0 * 30e-6;  // peak to peak along any axis: four encoder steps
};

/// How far the tool still goes to and fro at the end of a run: peak to peak along the worst axis;
/// infinite where it is nowhere.
[[nodiscard]] double swing_m(std::span<const recording::TickRow> rows, double window_s);

/// Whether the tool still swings at the end of a run, or is nowhere.
[[nodiscard]] bool oscillates(std::span<const recording::TickRow> rows,
                              const Oscillation& oscillation = {});

/// Where the largest stable stiffness is looked for: on the grid lowest, lowest * step, ... of four
/// digits each, so that what is printed can be asked for again.
struct StiffnessSearch {
  double lowest_N_per_m = 50.0;
  double highest_N_per_m = 30000.0;
  double step = 1.05;
};

/// The last stiffness of the grid before the first loss of stability, looked for upward, point by
/// point: all below it on the grid are stable, and what loses it within less than a step is not
/// seen. Nothing when the lowest is unstable already; the highest when none is.
[[nodiscard]] std::optional<double> largest_stable_stiffness_N_per_m(
    const std::function<bool(double stiffness_N_per_m)>& is_stable,
    const StiffnessSearch& search = {});

}  // namespace stillgrid::laboratory
