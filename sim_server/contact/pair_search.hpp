#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "shared/collision/still_grid.hpp"
#include "sim_server/contact/ball_tests.hpp"

namespace stillgrid {

/// The covers of a filled grid in the order of its cells, as a structure of arrays, with room for a
/// vector to read over the end.
struct SortedCovers {
  std::vector<float> x_m, y_m, z_m, reach_m;
  std::vector<std::uint32_t> cell;  // of each cover, where search_pairs() walks from cell to cell

  explicit SortedCovers(std::size_t capacity);
};

/// Writes to `pairs` every two spheres whose covers meet (grid_query.hpp: meet), each once. Grows
/// `pairs` where it has no room, and returns how many of it hold.
/// Pre: `sorted` has the capacity of the grid.
[[nodiscard]] std::size_t search_pairs(const GridView& view, SortedCovers& sorted,
                                       std::vector<SpherePair>& pairs);

}  // namespace stillgrid
