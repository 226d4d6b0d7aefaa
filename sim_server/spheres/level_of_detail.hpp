#pragma once

#include <vector>

#include "sim_server/spheres/decomposition.hpp"

namespace stillgrid::spheres {

/// Decompositions of the same solid from coarse to fine, each with its error; the last holds
/// finest_tolerance_m, each before it `factor` times the tolerance of the next, as far as
/// decompose() reaches them; each tells its tolerance_m.
///
/// Levels that need no fewer spheres than the next finer one are left out, so there may be fewer
/// than `levels`. Throws as decompose().
/// Pre: closed, as make_closed() leaves it; levels >= 1, factor > 1.
[[nodiscard]] std::vector<Decomposition> levels_of_detail(
    const mesh::TriangleMesh& closed, double finest_tolerance_m, int levels = 4,
    double factor = 2.0, const DecompositionProgress& progress = {});

}  // namespace stillgrid::spheres
