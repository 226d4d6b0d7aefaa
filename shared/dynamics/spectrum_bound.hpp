#pragma once

#include "shared/dynamics/description.hpp"

namespace stillgrid::dynamics {

/// Bounds of the vibrations of nodes and rigid bodies on springs and joints. No vibration is
/// faster, by the Cauchy-Schwarz inequality for each spring between masses m and n:
/// |x - y|^2 <= (1 + m / n) |x|^2 + (1 + n / m) |y|^2.
struct SpectrumBound {
  double frequency_rad_s = 0.0;  // fastest undamped vibration
  double damping_per_s = 0.0;    // at which dampers slow the fastest relative motion
};
[[nodiscard]] SpectrumBound spectrum_bound(const Description& description);

/// Returns the number of equal substeps of a tick by which Verlet's method is stable with a factor
/// of two to spare: half of the longest step h with (h w)^2 / 4 + h d / 2 = 1.
[[nodiscard]] int stable_substeps(const SpectrumBound& bound, double tick_s);

}  // namespace stillgrid::dynamics
