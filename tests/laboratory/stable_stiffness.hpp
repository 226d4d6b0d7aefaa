#pragma once

#include <functional>
#include <optional>

namespace stillgrid::laboratory {

/// Where the largest stable stiffness is looked for: on the grid lowest, lowest * step, ... of four
/// digits each, so that what is printed can be asked for again.
struct StiffnessSearch {
  double lowest_N_per_m = 200.0;
  double highest_N_per_m = 20000.0;
  double step = 1.05;
  double from_N_per_m = 0.0;  // points of the grid below are not asked
};

/// The last stiffness of the grid before the first loss of stability, looked for upward, point by
/// point: all below it on the grid are stable, and what loses it within less than a step is not
/// seen. Nothing when the first asked is unstable already; the highest when none is.
[[nodiscard]] std::optional<double> largest_stable_stiffness_N_per_m(
    const std::function<bool(double stiffness_N_per_m)>& is_stable,
    const StiffnessSearch& search = {});

}  // namespace stillgrid::laboratory
