#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "shared/collision/voxel_grid.hpp"

namespace stillgrid::collision {

/// Swept bounds that a seed decides, and the ratio to enter them with.
struct RandomScene {
  std::vector<SweptBound> swept_bounds;
  float voxel_ratio = 1.0F;
};

/// The kinds of scenes a grid must not tell apart.
enum class SceneKind {
  kScattered,   // reaches over two decades: several levels
  kOnBorders,   // centres and faces exactly on borders between voxels
  kCoincident,  // many swept bounds at one centre
  kFarAway,     // 1e6 m from the origin, on its negative side
  kWide,        // far wider than the cells, so that the grid repeats
  kCount
};

[[nodiscard]] RandomScene random_scene(SceneKind kind, std::uint64_t seed, std::size_t count);

/// Of the first seeds: no sphere, one, two, then up to 300.
[[nodiscard]] RandomScene random_scene(SceneKind kind, std::uint64_t seed);

/// A grid with the scene's swept bounds entered; records are left empty.
[[nodiscard]] VoxelGrid grid_of(const RandomScene& scene);

/// Spheres that move through the snapshots of their history by up to a tenth of a metre.
[[nodiscard]] std::vector<proto::SphereRecord> random_histories(std::uint64_t seed,
                                                                std::size_t count);

/// Whether two balls meet, exactly up to double's rounding.
[[nodiscard]] bool meet_exactly(const SweptBound& a, const SweptBound& b);

}  // namespace stillgrid::collision
