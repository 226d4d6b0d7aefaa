#pragma once

#include <vector>

#include "sim_server/spheres/decomposition.hpp"

namespace stillgrid::spheres {

/// What is asked of the spheres of a mesh: one of the three, more than 0.
struct Fineness {
  double tolerance_m = 0.0;        // few spheres, no farther from the surface
  double surface_spacing_m = 0.0;  // even ones below the surface, so far apart
  double volume_spacing_m = 0.0;   // even ones throughout
};

/// The spheres asked for, from coarse to fine, each with its error: `levels` of them of a
/// tolerance, one of a spacing. Throws as levels_of_detail(), firm_surface_balls() and
/// firm_volume_balls().
/// Pre: closed, as make_closed() leaves it; levels >= 1.
[[nodiscard]] std::vector<Decomposition> cover_mesh(const mesh::TriangleMesh& closed,
                                                    const Fineness& fineness, int levels = 1,
                                                    const DecompositionProgress& progress = {});

}  // namespace stillgrid::spheres
