#pragma once

#include <nlohmann/json_fwd.hpp>

#include "shared/realtime/histogram.hpp"

namespace stillgrid::reading {

/// A distribution as every report tells it, in numbers of `unit`: docs/formats.md, "Reports".
[[nodiscard]] nlohmann::json histogram_json(const realtime::Histogram& histogram, double unit);

}  // namespace stillgrid::reading
