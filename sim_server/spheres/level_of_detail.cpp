#include "sim_server/spheres/level_of_detail.hpp"

#include <algorithm>
#include <utility>

namespace stillgrid::spheres {

std::vector<Decomposition> levels_of_detail(const mesh::TriangleMesh& closed,
                                            double finest_tolerance_m, int levels, double factor,
                                            const DecompositionProgress& progress) {
  std::vector<Decomposition> series;
  double tolerance_m = finest_tolerance_m;
  for (int level = 0; level < levels; ++level, tolerance_m *= factor) {
    Decomposition next = decompose(closed, tolerance_m, progress);
    const bool is_coarser = series.empty() || next.balls.size() < series.back().balls.size();
    if (is_coarser) series.push_back(std::move(next));
    if (series.back().balls.size() == 1) break;
  }
  std::reverse(series.begin(), series.end());
  return series;
}

}  // namespace stillgrid::spheres
