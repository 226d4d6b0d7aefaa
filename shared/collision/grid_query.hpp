#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "shared/collision/voxel_grid.hpp"

namespace stillgrid::collision {

/// The voxel that holds a coordinate. Monotone, saturating. Realtime: yes.
[[nodiscard]] inline std::int32_t voxel_index(float coordinate_m,
                                              float inverse_voxel_per_m) noexcept {
  constexpr float kFarthest = 1073741824.0F;  // 2^30: differences of two stay in 32 bits
  // A NaN is no place; min and max in this order send it to one end instead of to undefined
  // conversion.
  const float place = std::max(-kFarthest, std::min(kFarthest, coordinate_m * inverse_voxel_per_m));
  const auto towards_zero = static_cast<std::int32_t>(place);
  return towards_zero - static_cast<std::int32_t>(static_cast<float>(towards_zero) > place);
}

/// Four numbers that a processor handles at once, whatever its kind.
using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));
using Unsigned4 = std::uint32_t __attribute__((vector_size(16)));
using Long2 = std::uint64_t __attribute__((vector_size(16)));

/// The voxels that hold coordinates. Monotone, saturating; a NaN is at one end. Realtime: yes.
[[nodiscard]] inline Int4 voxel_index(Float4 coordinates_m, float inverse_voxel_per_m) noexcept {
  constexpr float kFarthest = 1073741824.0F;  // 2^30: differences of two stay in 32 bits
  const Float4 place = coordinates_m * inverse_voxel_per_m;
  const Float4 high = place < kFarthest ? place : Float4{} + kFarthest;
  const Float4 bounded = high > -kFarthest ? high : Float4{} - kFarthest;
  const Int4 towards_zero = __builtin_convertvector(bounded, Int4);
  return towards_zero + (__builtin_convertvector(towards_zero, Float4) > bounded);  // true is -1
}

/// The voxels where centres can be that are no farther than distance_m from `centre_m` in exact
/// arithmetic. Realtime: yes.
struct VoxelBox {
  Int4 lowest, highest;
};
[[nodiscard]] inline VoxelBox voxel_box(const std::array<float, 3>& centre_m, float distance_m,
                                        float inverse_voxel_per_m) noexcept {
  const Float4 centre{centre_m[0], centre_m[1], centre_m[2], 0.0F};
  constexpr float kUlp = 1.2e-7F;  // what rounding takes off
  const Float4 away = distance_m + kUlp * ((centre < 0.0F ? -centre : centre) + distance_m);
  return {voxel_index(centre - away, inverse_voxel_per_m),
          voxel_index(centre + away, inverse_voxel_per_m)};
}

/// The cells of a level that hold the voxels of a box, along x, y and z: `count` from `first` on,
/// going round at `cells`. The fourth of each says nothing.
struct CellBlock {
  Unsigned4 first, count, cells;
  bool is_empty;  // no swept bound's centre can be there
};

/// Where the centres can be that are no farther than distance_m from `centre_m` in exact
/// arithmetic. Realtime: yes.
[[nodiscard]] inline CellBlock cell_block(const proto::GridLevel& level,
                                          const std::array<float, 3>& centre_m, float distance_m,
                                          float inverse_voxel_per_m) noexcept {
  struct Rows {
    Int4 lowest, highest;
    Unsigned4 cells;
  };
  const auto rows = std::bit_cast<Rows>(level);
  const auto [from, to] = voxel_box(centre_m, distance_m, inverse_voxel_per_m);
  const Int4 low = from > rows.lowest ? from : rows.lowest;
  const Int4 high = to < rows.highest ? to : rows.highest;
  const Int4 none = low > high;
  // Where the level does not repeat the mask changes nothing.
  const auto offset = std::bit_cast<Unsigned4>(low) - std::bit_cast<Unsigned4>(rows.lowest);
  const auto voxels = std::bit_cast<Unsigned4>(high) - std::bit_cast<Unsigned4>(low);
  return {offset < rows.cells ? offset : (offset & (rows.cells - 1)),
          voxels < rows.cells ? voxels + 1 : rows.cells, rows.cells,
          (none[0] | none[1] | none[2]) != 0};
}

[[nodiscard]] inline SweptBound load_bound(const GridView& view, std::size_t i) noexcept {
  return double_buffer::load_struct<SweptBound>(view.words + view.layout.swept_bounds + 2 * i);
}
[[nodiscard]] inline std::uint32_t load_number(const GridView& view, std::size_t i) noexcept {
  return double_buffer::load_u32(view.words + view.layout.numbers, i);
}

[[nodiscard]] inline std::size_t record_word(const GridView& view, std::uint32_t sphere) noexcept {
  return view.layout.records + std::size_t{sphere} * (sizeof(proto::SphereRecord) / 8);
}
[[nodiscard]] inline proto::SphereRecord load_record(const GridView& view,
                                                     std::uint32_t sphere) noexcept {
  return double_buffer::load_struct<proto::SphereRecord>(view.words + record_word(view, sphere));
}

/// Pre: 1 <= moving <= view.field_count.
[[nodiscard]] inline proto::FieldRecord load_field(const GridView& view,
                                                   std::uint32_t moving) noexcept {
  return double_buffer::load_struct<proto::FieldRecord>(
      view.fields + std::size_t{moving - 1} * (sizeof(proto::FieldRecord) / 8));
}

/// Whether two swept bounds meet. Swept bounds are rounded outwards by more than this test rounds.
[[nodiscard]] inline bool meet(const SweptBound& a, const SweptBound& b) noexcept {
  const float x = a.centre_m[0] - b.centre_m[0], y = a.centre_m[1] - b.centre_m[1],
              z = a.centre_m[2] - b.centre_m[2],
              bounding_radius_m = a.bounding_radius_m + b.bounding_radius_m;
  return x * x + y * y + z * z <= bounding_radius_m * bounding_radius_m;
}

/// No limit: for the simulation, which trusts its own grid.
inline constexpr std::uint32_t kAllVisits = std::numeric_limits<std::uint32_t>::max();

namespace detail {

/// Counts down the swept bounds and rows of cells a query may look at.
struct VisitBudget {
  std::uint32_t left;
  bool truncated = false;
  bool spend(std::uint32_t wanted) noexcept {
    truncated = wanted > left;
    left = truncated ? 0 : left - wanted;
    return !truncated;
  }
};

/// Four floats that begin with a word.
[[nodiscard]] inline Float4 load4(const std::uint64_t* words) noexcept {
  return std::bit_cast<Float4>(
      Long2{double_buffer::load_word(words, 0), double_buffer::load_word(words, 1)});
}

/// A bit for each that holds.
[[nodiscard]] inline unsigned bits_of(Int4 holds) noexcept {
  constexpr Int4 kBits{1, 2, 4, 8};
  const auto halves = std::bit_cast<std::array<std::uint64_t, 2>>(holds & kBits);
  const std::uint64_t pairs = halves[0] | halves[1];
  return static_cast<unsigned>(pairs | (pairs >> 32U));
}

/// Which of the four swept bounds from number `i` on meet the probe, a bit each.
[[nodiscard]] inline unsigned meet4(const std::uint64_t* swept_bounds, std::size_t i,
                                    const SweptBound& probe) noexcept {
  const auto load = [&](std::size_t swept_bound) { return load4(swept_bounds + 2 * swept_bound); };
  const Float4 a = load(i), b = load(i + 1), c = load(i + 2), d = load(i + 3);
  const Float4 xy_ab = __builtin_shufflevector(a, b, 0, 4, 1, 5);
  const Float4 zr_ab = __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const Float4 xy_cd = __builtin_shufflevector(c, d, 0, 4, 1, 5);
  const Float4 zr_cd = __builtin_shufflevector(c, d, 2, 6, 3, 7);
  const Float4 x = __builtin_shufflevector(xy_ab, xy_cd, 0, 1, 4, 5) - probe.centre_m[0];
  const Float4 y = __builtin_shufflevector(xy_ab, xy_cd, 2, 3, 6, 7) - probe.centre_m[1];
  const Float4 z = __builtin_shufflevector(zr_ab, zr_cd, 0, 1, 4, 5) - probe.centre_m[2];
  const Float4 bounding_radius =
      __builtin_shufflevector(zr_ab, zr_cd, 2, 3, 6, 7) + probe.bounding_radius_m;
  return bits_of(x * x + y * y + z * z <= bounding_radius * bounding_radius);
}

/// Visits the swept bounds of the cells [first, end) that meet the probe, by fours: a run's length
/// is what a processor cannot predict.
template <class Visit>
void visit_run(const GridView& view, std::size_t first_cell, std::size_t end_cell,
               const SweptBound& probe, VisitBudget& budget, Visit& visit) {
  const std::uint64_t* starts = view.words + view.layout.cell_starts;
  const std::uint32_t first = double_buffer::load_u32(starts, first_cell);
  const std::uint32_t end =
      std::min(double_buffer::load_u32(starts, end_cell), view.shape.sphere_count);
  if (first >= end) return;
  const std::uint32_t left = budget.left;
  const std::uint32_t stop = budget.spend(end - first) ? end : first + left;
  for (std::uint32_t i = first; i < stop; i += kBoundsAtOnce) {
    unsigned met = meet4(view.words + view.layout.swept_bounds, i, probe);
    met &= 0xFU >> (kBoundsAtOnce - std::min(stop - i, kBoundsAtOnce));
    for (; met != 0; met &= met - 1) {
      const std::uint32_t sphere =
          load_number(view, i + static_cast<unsigned>(std::countr_zero(met)));
      if (sphere < view.shape.sphere_count) visit(sphere);  // else a torn or hostile word
    }
  }
}

template <class Visit>
void visit_level(const GridView& view, const proto::GridLevel& level, const SweptBound& probe,
                 VisitBudget& budget, Visit& visit) {
  const CellBlock block =
      cell_block(level, probe.centre_m, probe.bounding_radius_m + level.bounding_radius_m,
                 1.0F / level.voxel_m);
  if (block.is_empty) return;
  const auto& [first, count, cells, is_empty] = block;
  const std::uint32_t straight = std::min(count[0], cells[0] - first[0]);
  const auto wrapped = [](std::uint32_t cell, std::uint32_t all) {
    return cell < all ? cell : cell - all;
  };
  for (std::uint32_t k = 0; k < count[2]; ++k)
    for (std::uint32_t j = 0; j < count[1]; ++j) {
      if (!budget.spend(1)) return;
      const std::size_t row =
          level.first_cell +
          std::size_t{cells[0]} * (wrapped(first[1] + j, cells[1]) +
                                   std::size_t{cells[1]} * wrapped(first[2] + k, cells[2]));
      visit_run(view, row + first[0], row + first[0] + straight, probe, budget, visit);
      if (budget.truncated) return;
      if (straight < count[0])  // the row goes round
        visit_run(view, row, row + (count[0] - straight), probe, budget, visit);
    }
}

}  // namespace detail

/// Calls visit(sphere number) once for each sphere whose swept bound meets the probe's. Looks at
/// `max_visits` swept bounds and rows of cells at most and returns whether it was cut short there.
///
/// Realtime: wait-free; safe on words that change or lie, given is_consistent(view.shape).
template <class Visit>
bool for_each_candidate(const GridView& view, const SweptBound& probe, std::uint32_t max_visits,
                        Visit&& visit) {
  detail::VisitBudget budget{max_visits};
  for (std::uint32_t i = 0; i < view.shape.level_count && !budget.truncated; ++i)
    detail::visit_level(view, view.shape.levels[i], probe, budget, visit);
  return budget.truncated;
}

}  // namespace stillgrid::collision
