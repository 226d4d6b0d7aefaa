#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace stillgrid::realtime {

/// The smallest of the values that at least that share of them does not exceed; 0 of none. Not
/// real-time: for what is kept whole; Histogram counts on the way.
[[nodiscard]] inline double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(std::max(rank, 1.0)) - 1;
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

}  // namespace stillgrid::realtime
