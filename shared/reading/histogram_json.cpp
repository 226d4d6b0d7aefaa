#include "shared/reading/histogram_json.hpp"

#include <nlohmann/json.hpp>

namespace stillgrid::reading {

nlohmann::json histogram_json(const realtime::Histogram& histogram, double unit) {
  const auto at = [&](double share) {
    return static_cast<double>(histogram.percentile(share)) * unit;
  };
  return {{"p50", at(0.5)},
          {"p99", at(0.99)},
          {"p999", at(0.999)},
          {"max", static_cast<double>(histogram.max()) * unit}};
}

}  // namespace stillgrid::reading
