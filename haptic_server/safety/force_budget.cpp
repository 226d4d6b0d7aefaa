#include "haptic_server/safety/force_budget.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid::safety {

double ForceBudget::limit(double max) const noexcept {
  constexpr double kWarm = 0.8;
  if (!(continuous_ < max)) return max;
  const double used = heat_ / (continuous_ * continuous_);
  const double left = std::clamp((1.0 - used) / (1.0 - kWarm), 0.0, 1.0);
  return continuous_ + left * (max - continuous_);
}

void ForceBudget::spend(double held, double elapsed_s) noexcept {
  // Exact for what is held over the time.
  heat_ += -std::expm1(-elapsed_s / time_constant_s_) * (held * held - heat_);
}

}  // namespace stillgrid::safety
