#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "shared/collision/still_grid.hpp"

namespace stillgrid {

using Voxel = std::array<std::int32_t, 3>;

inline std::int32_t voxel_index(float coordinate_m, float inverse_voxel_per_m) noexcept {
  constexpr float kFarthest = 1073741824.0F;  // 2^30: differences of two stay in 32 bits
  const float voxel = std::floor(coordinate_m * inverse_voxel_per_m);
  // A NaN is no place; min and max in this order send it to one end instead of to undefined
  // behaviour.
  return static_cast<std::int32_t>(std::max(-kFarthest, std::min(kFarthest, voxel)));
}

/// The cell that stores a voxel: its coordinates modulo the cells along each axis. Realtime: yes.
[[nodiscard]] inline std::size_t cell_of(const Voxel& voxel,
                                         const std::array<std::uint32_t, 3>& log2_cells) noexcept {
  const auto wrapped = [&](std::size_t axis) {
    const std::size_t mask = (std::size_t{1} << log2_cells[axis]) - 1;
    return static_cast<std::size_t>(static_cast<std::uint32_t>(voxel[axis])) & mask;
  };
  return wrapped(0) | (wrapped(1) << log2_cells[0]) |
         (wrapped(2) << (log2_cells[0] + log2_cells[1]));
}

/// The one voxel in which a pair is reported: the elementwise maximum of the two boxes' lowest
/// voxels. Both boxes hold it if they meet, so no stamp need be written to find a pair only once.
[[nodiscard]] inline Voxel reporting_voxel(const Voxel& a, const Voxel& b) noexcept {
  return {std::max(a[0], b[0]), std::max(a[1], b[1]), std::max(a[2], b[2])};
}

/// The first cache line of a SphereRecord: what a query needs of most spheres.
struct RecordLine {
  std::array<proto::SphereImage, 2> newest;
  float radius_m;
  Voxel lowest_voxel;
};
static_assert(sizeof(RecordLine) == 64);

/// The end of that line, which alone decides whether a sphere is this voxel's to report.
struct RecordPlace {
  float radius_m;
  Voxel lowest_voxel;
};
static_assert(sizeof(RecordPlace) == 16 && offsetof(RecordLine, radius_m) == 48);

[[nodiscard]] inline std::size_t record_word(const GridView& view, std::uint32_t sphere) noexcept {
  return view.layout.records + std::size_t{sphere} * (sizeof(proto::SphereRecord) / 8);
}
[[nodiscard]] inline RecordLine load_line(const GridView& view, std::uint32_t sphere) noexcept {
  return load_struct<RecordLine>(view.words + record_word(view, sphere));
}
[[nodiscard]] inline Voxel load_lowest_voxel(const GridView& view, std::uint32_t sphere) noexcept {
  const std::size_t word = record_word(view, sphere) + offsetof(RecordLine, radius_m) / 8;
  return load_struct<RecordPlace>(view.words + word).lowest_voxel;
}
[[nodiscard]] inline proto::SphereRecord load_record(const GridView& view,
                                                     std::uint32_t sphere) noexcept {
  return load_struct<proto::SphereRecord>(view.words + record_word(view, sphere));
}

/// No limit: for the simulation, which trusts its own grid.
inline constexpr std::uint32_t kAllVisits = std::numeric_limits<std::uint32_t>::max();

namespace detail {

/// Counts down the entries a query may look at.
struct VisitBudget {
  std::uint32_t left;
  bool cut = false;
  bool spend() noexcept {
    if (left == 0) {
      cut = true;
      return false;
    }
    --left;
    return true;
  }
};

template <class Visit>
void visit_cell(const GridView& view, const Voxel& voxel, const Voxel& box_lowest,
                VisitBudget& budget, Visit& visit) {
  const std::size_t cell = cell_of(voxel, view.shape.log2_cells);
  const std::uint64_t* starts = view.words + view.layout.cell_starts;
  const std::uint32_t first = load_u32(starts, cell);
  const std::uint32_t end = std::min(load_u32(starts, cell + 1), view.shape.entry_count);
  for (std::uint32_t i = first; i < end; ++i) {
    if (!budget.spend()) return;
    const std::uint32_t sphere = load_u32(view.words + view.layout.entries, i);
    if (sphere >= view.shape.sphere_count) continue;  // a torn or hostile word
    if (reporting_voxel(load_lowest_voxel(view, sphere), box_lowest) == voxel)
      visit(sphere, load_line(view, sphere));
  }
}

/// Every sphere that is not on the long list, which ascends.
template <class Visit>
void visit_entered(const GridView& view, VisitBudget& budget, Visit& visit) {
  std::uint32_t next_long = 0;
  for (std::uint32_t sphere = 0; sphere < view.shape.sphere_count && budget.spend(); ++sphere) {
    if (next_long < view.shape.long_count &&
        load_u32(view.words + view.layout.long_list, next_long) == sphere)
      ++next_long;
    else
      visit(sphere, load_line(view, sphere));
  }
}

}  // namespace detail

/// Calls visit(sphere number, RecordLine) once for each sphere whose swept box may meet `box`;
/// spheres that it does not meet may be among them. Looks at `max_visits` entries and voxels at
/// most and returns whether it was cut short there.
///
/// Realtime: wait-free; safe on words that change or lie, given is_consistent(view.shape).
template <class Visit>
bool for_each_candidate(const GridView& view, const Box& box, std::uint32_t max_visits,
                        Visit&& visit) {
  if (view.shape.sphere_count == 0) return false;
  detail::VisitBudget budget{max_visits};
  for (std::uint32_t i = 0; i < view.shape.long_count && budget.spend(); ++i) {
    const std::uint32_t sphere = load_u32(view.words + view.layout.long_list, i);
    if (sphere < view.shape.sphere_count) visit(sphere, load_line(view, sphere));
  }
  if (view.shape.entry_count == 0) return budget.cut;
  const float inverse_voxel_per_m = 1.0F / view.shape.voxel_m;
  Voxel low{}, high{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low[axis] = voxel_index(box.low_m[axis], inverse_voxel_per_m);
    high[axis] = voxel_index(box.high_m[axis], inverse_voxel_per_m);
  }
  double voxels = 1.0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    voxels *= static_cast<double>(high[axis]) - static_cast<double>(low[axis]) + 1.0;
  if (voxels > view.shape.sphere_count) {  // fewer spheres than places to look for them
    detail::visit_entered(view, budget, visit);
    return budget.cut;
  }
  for (std::int32_t z = low[2]; z <= high[2] && !budget.cut; ++z)
    for (std::int32_t y = low[1]; y <= high[1] && !budget.cut; ++y)
      for (std::int32_t x = low[0]; x <= high[0] && !budget.cut; ++x)
        if (budget.spend()) detail::visit_cell(view, {x, y, z}, low, budget, visit);
  return budget.cut;
}

/// Calls visit(a, b), a < b, once for each pair of spheres of one grid that share a voxel where
/// their boxes meet, and for each pair with a sphere of the long list; pairs that do not touch may
/// be among them. Thread: the owner's of the grid.
template <class Visit>
void for_each_pair(const GridView& view, Visit&& visit) {
  const auto& shape = view.shape;
  const std::uint64_t* starts = view.words + view.layout.cell_starts;
  const std::uint64_t* entries = view.words + view.layout.entries;
  const auto* const records =
      reinterpret_cast<const proto::SphereRecord*>(view.words + view.layout.records);
  const std::size_t cells = std::size_t{1}
                            << (shape.log2_cells[0] + shape.log2_cells[1] + shape.log2_cells[2]);
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const std::uint32_t end = load_u32(starts, cell + 1);
    for (std::uint32_t i = load_u32(starts, cell); i < end; ++i)
      for (std::uint32_t j = i + 1; j < end; ++j) {
        const std::uint32_t a = load_u32(entries, i), b = load_u32(entries, j);
        const Voxel voxel = reporting_voxel(records[a].lowest_voxel, records[b].lowest_voxel);
        if (cell_of(voxel, shape.log2_cells) == cell) visit(a, b);
      }
  }
  std::size_t next_long = 0;
  for (std::uint32_t i = 0; i < shape.long_count; ++i) {
    const std::uint32_t a = load_u32(view.words + view.layout.long_list, i);
    // Ascending list: a long sphere meets every sphere but the long ones before it.
    next_long = 0;
    for (std::uint32_t b = 0; b < shape.sphere_count; ++b) {
      if (next_long <= i && b == load_u32(view.words + view.layout.long_list, next_long)) {
        ++next_long;
        continue;
      }
      visit(std::min(a, b), std::max(a, b));
    }
  }
}

}  // namespace stillgrid
