#include "shared/tools/scene_viewer/voxels.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "shared/collision/grid_query.hpp"

namespace stillgrid::scene_viewer {

std::vector<OccupiedVoxel> occupied_voxels(const proto::GridShape& grid,
                                           std::span<const reading::LevelBound> swept_bounds) {
  using Place = std::array<std::int32_t, 4>;  // level, z, y, x
  std::vector<Place> places;
  for (const auto& [swept_bound, level] : swept_bounds) {
    const auto& centre_m = swept_bound.centre_m;
    if (!std::all_of(centre_m.begin(), centre_m.end(), [](float x) { return std::isfinite(x); }))
      continue;
    const float inverse_voxel_per_m = 1.0F / grid.levels[level].voxel_m;
    const auto voxel = [&](std::size_t axis) {
      return collision::voxel_index(centre_m[axis], inverse_voxel_per_m);
    };
    places.push_back({static_cast<std::int32_t>(level), voxel(2), voxel(1), voxel(0)});
  }
  std::sort(places.begin(), places.end());
  std::vector<OccupiedVoxel> voxels;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (i > 0 && places[i] == places[i - 1]) {
      ++voxels.back().spheres;
      continue;
    }
    const float edge_m = grid.levels[static_cast<std::size_t>(places[i][0])].voxel_m;
    const auto middle_m = [&](std::size_t axis) {
      return (static_cast<float>(places[i][3 - axis]) + 0.5F) * edge_m;
    };
    voxels.push_back({{middle_m(0), middle_m(1), middle_m(2)}, edge_m, 1});
  }
  return voxels;
}

}  // namespace stillgrid::scene_viewer
