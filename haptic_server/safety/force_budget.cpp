#include "haptic_server/safety/force_budget.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid::safety {

double ForceBudget::limit_N(double max_force_N) const noexcept {
  constexpr double kWarm = 0.8;
  if (!(continuous_N_ < max_force_N)) return max_force_N;
  const double used = heat_N2_ / (continuous_N_ * continuous_N_);
  const double left = std::clamp((1.0 - used) / (1.0 - kWarm), 0.0, 1.0);
  return continuous_N_ + left * (max_force_N - continuous_N_);
}

void ForceBudget::spend(double force_N, double elapsed_s) noexcept {
  // Exact for a force held over the time.
  heat_N2_ += -std::expm1(-elapsed_s / time_constant_s_) * (force_N * force_N - heat_N2_);
}

}  // namespace stillgrid::safety
