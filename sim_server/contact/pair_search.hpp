#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/collision/voxel_grid.hpp"
#include "sim_server/contact/ball_tests.hpp"

namespace stillgrid::contact {

/// The group of a sphere that may be paired with any other.
inline constexpr std::uint32_t kNoGroup = 0xffff'ffff;

/// The swept bounds of a filled grid in the order of its cells, as a structure of arrays, with room
/// for a vector to read over the end.
struct SortedBounds {
  std::vector<float> x_m, y_m, z_m, bounding_radius_m;
  std::vector<std::uint32_t>
      cell;  // of each swept bound, where search_pairs() walks from cell to cell

  // Of each swept bound, where there are groups: which, and where the next swept bound of another
  // one stands.
  std::vector<std::uint32_t> group, group_end;

  explicit SortedBounds(std::size_t capacity);
};

/// Writes to `pairs` every two spheres whose swept bounds meet (grid_query.hpp: meet), each once,
/// but for those of one group. Grows `pairs` where it has no room, and returns how many of it hold;
/// more than `most`, and only that, where there are.
///
/// groups: of each sphere; none: there are no groups. Swept bounds of one group that stand together
/// in the grid, as a rigid body's do, cost one look however many they are. Pre: `sorted` has the
/// capacity of the grid.
[[nodiscard]] std::size_t search_pairs(const collision::GridView& view,
                                       std::span<const std::uint32_t> groups, std::size_t most,
                                       SortedBounds& sorted, std::vector<SpherePair>& pairs);

}  // namespace stillgrid::contact
