#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/reading/snapshot.hpp"

namespace stillgrid::scene_viewer {

/// A voxel that spheres are entered in.
struct OccupiedVoxel {
  std::array<float, 3> centre_m{};  // world frame
  float edge_m = 0.0F;
  std::uint32_t spheres = 0;
};

/// Every occupied voxel once, by level, z, y, x. Covers that are nowhere are left out.
[[nodiscard]] std::vector<OccupiedVoxel> occupied_voxels(
    const proto::GridShape& grid, std::span<const reading::LevelBound> swept_bounds);

}  // namespace stillgrid::scene_viewer
