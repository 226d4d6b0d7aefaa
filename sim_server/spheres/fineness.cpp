#include "sim_server/spheres/fineness.hpp"

#include <algorithm>

#include "sim_server/spheres/decomposition_error.hpp"
#include "sim_server/spheres/sampling.hpp"

namespace stillgrid::spheres {

Decomposition cover_mesh(const mesh::TriangleMesh& closed, const Fineness& fineness,
                         const DecompositionProgress& progress) {
  if (fineness.tolerance_m > 0.0) return decompose(closed, fineness.tolerance_m, progress);
  const double surface_m = fineness.surface_spacing_m, volume_m = fineness.volume_spacing_m;
  constexpr double kOfSpacing = 0.05;  // of the measured error, in spacings
  return with_error(
      MeshSolid(closed),
      surface_m > 0.0 ? firm_surface_balls(closed, surface_m) : firm_volume_balls(closed, volume_m),
      kOfSpacing * std::max(surface_m, volume_m));
}

}  // namespace stillgrid::spheres
