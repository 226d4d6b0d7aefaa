#pragma once

#include "sim_server/spheres/decomposition.hpp"

namespace stillgrid::spheres {

/// What is asked of the spheres of a mesh: one of the three, more than 0.
struct Fineness {
  double tolerance_m = 0.0;        // few spheres, no farther from the surface
  double surface_spacing_m = 0.0;  // even ones below the surface, so far apart
  double volume_spacing_m = 0.0;   // even ones throughout
};

/// Returns the spheres asked for, with their error. Throws as decompose(), firm_surface_balls() and
/// firm_volume_balls(). Pre: closed, as make_closed() leaves it.
[[nodiscard]] Decomposition cover_mesh(const mesh::TriangleMesh& closed, const Fineness& fineness,
                                       const DecompositionProgress& progress = {});

}  // namespace stillgrid::spheres
