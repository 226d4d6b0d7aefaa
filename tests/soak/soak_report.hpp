#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "tests/soak/soak_runs.hpp"

namespace stillgrid::soak {

/// The figures of a soak, and under "broken_laws" what they should not be.
[[nodiscard]] nlohmann::ordered_json soak_report(const SoakPlan& plan, const SoakState& state,
                                                 const std::optional<KillTally>& kills,
                                                 bool is_complete, double seconds);

/// A line a figure, on standard output.
void print(const nlohmann::ordered_json& report);

}  // namespace stillgrid::soak
