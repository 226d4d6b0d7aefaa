#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "shared/collision/still_grid.hpp"

namespace stillgrid {

/// A scene of moving spheres that a seed decides, and the voxel edge to enter it with.
struct RandomScene {
  std::vector<proto::SphereRecord> spheres;
  float voxel_m;
};

/// The kinds of scenes a grid must not tell apart.
enum class SceneKind {
  kScattered,   // radii over two decades, images of a history apart
  kOnBorders,   // centres and faces on borders between voxels
  kCoincident,  // many spheres at one centre
  kFarAway,     // 1e6 m from the origin, on its negative side
  kWide,        // far wider than the cells, so that the grid repeats
  kCount
};

[[nodiscard]] RandomScene random_scene(SceneKind kind, std::uint64_t seed);

/// A grid filled with the scene's spheres.
[[nodiscard]] StillGrid grid_of(const RandomScene& scene);

/// A sphere that stands still at one place in all images.
[[nodiscard]] proto::SphereRecord still_sphere(const std::array<float, 3>& position_m,
                                               float radius_m);

/// Position of image 0 (newest) to 3.
[[nodiscard]] const std::array<float, 3>& position_of(const proto::SphereRecord& sphere,
                                                      std::size_t image);

/// Whether two spheres overlap in one image, exactly up to double's rounding.
[[nodiscard]] bool overlap(const proto::SphereRecord& a, const proto::SphereRecord& b,
                           std::size_t image);

/// Whether two closed boxes meet.
[[nodiscard]] bool meet(const Box& a, const Box& b);

}  // namespace stillgrid
