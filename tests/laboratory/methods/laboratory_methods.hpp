#pragma once

#include "sim_server/scene/method.hpp"

namespace stillgrid::laboratory {

/// The integrators that a scene may name in the laboratory: the product's and "broyden"
/// (docs/algorithms/integrators.md).
[[nodiscard]] scene::Integrators laboratory_methods() noexcept;

}  // namespace stillgrid::laboratory
