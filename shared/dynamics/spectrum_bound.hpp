#pragma once

#include "shared/dynamics/description.hpp"

namespace stillgrid::dynamics {

/// Bounds of the vibrations of nodes and rigid bodies on springs and joints. No vibration is
/// faster, by the Cauchy-Schwarz inequality for each spring: k (a - b)^2 <= 2 k (a^2 + b^2).
struct SpectrumBound {
  double frequency_rad_s = 0.0;  // fastest undamped vibration
  double damping_per_s = 0.0;    // at which dampers slow the fastest relative motion
};
[[nodiscard]] SpectrumBound spectrum_bound(const Description& description);

}  // namespace stillgrid::dynamics
