#include "shared/collision/grid_levels.hpp"

#include <array>
#include <cmath>

namespace stillgrid::collision {

std::uint64_t extent_voxels(const proto::GridLevel& level, std::size_t axis) noexcept {
  return static_cast<std::uint64_t>(std::int64_t{level.highest_voxel[axis]} -
                                    level.lowest_voxel[axis] + 1);
}

std::uint64_t cell_count(const proto::GridLevel& level) noexcept {
  return std::uint64_t{level.cells[0]} * level.cells[1] * level.cells[2];
}

std::array<std::uint32_t, 3> cells_for(const proto::GridLevel& level, std::size_t spheres) {
  const std::size_t max_cells = std::max(kCellsPerSphere * spheres, kLeastCells);
  std::array<std::uint64_t, 3> cells{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    cells[axis] = std::min<std::uint64_t>(extent_voxels(level, axis), std::uint64_t{1} << 31U);
  const auto fits = [&] {
    return static_cast<double>(cells[0]) * static_cast<double>(cells[1]) *
               static_cast<double>(cells[2]) <=
           static_cast<double>(max_cells);
  };
  while (!fits()) {
    auto& longest = *std::max_element(cells.begin(), cells.end());
    longest = std::bit_floor(longest - 1);
  }
  return {static_cast<std::uint32_t>(cells[0]), static_cast<std::uint32_t>(cells[1]),
          static_cast<std::uint32_t>(cells[2])};
}

bool is_consistent_level(const proto::GridLevel& level, std::size_t cell_capacity) noexcept {
  if (!(level.voxel_m > 0.0F) || !std::isfinite(1.0F / level.voxel_m) ||
      !(level.bounding_radius_m >= 0.0F) || !std::isfinite(level.bounding_radius_m))
    return false;
  std::uint64_t cells = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (level.highest_voxel[axis] < level.lowest_voxel[axis] || level.cells[axis] == 0 ||
        level.cells[axis] > cell_capacity)
      return false;
    const bool repeats = extent_voxels(level, axis) > level.cells[axis];
    if (repeats && !std::has_single_bit(level.cells[axis])) return false;
    cells *= level.cells[axis];
    if (cells > cell_capacity) return false;
  }
  return level.first_cell <= cell_capacity - cells;
}

}  // namespace stillgrid::collision
