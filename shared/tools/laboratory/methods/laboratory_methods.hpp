#pragma once

#include "sim_server/scene/method.hpp"

namespace stillgrid::laboratory {

/// What a scene may name in the laboratory: the product's methods, and those that are measured
/// beside (docs/algorithms/integrators.md).
[[nodiscard]] scene::MethodTable laboratory_methods() noexcept;

}  // namespace stillgrid::laboratory
