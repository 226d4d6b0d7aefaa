#include "sim_server/contact/pair_search.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

#include "shared/collision/grid_query.hpp"
#include "sim_server/contact/vector_row.hpp"

// One code for every instruction set that Highway knows; the best is chosen when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim_server/contact/pair_search.cpp"
#include <hwy/foreach_target.h>  // first: highway.h depends on it
#include <hwy/highway.h>

#ifndef STILLGRID_PAIR_SEARCH_ONCE
#define STILLGRID_PAIR_SEARCH_ONCE
namespace stillgrid::contact {
namespace {

/// Swept bounds that one look at a run of cells tests: as many bits.
constexpr std::uint32_t kBounds = kLanes;

/// A search that can stop for want of room, and go on.
struct Search {
  const collision::GridView& view;
  const SortedBounds& swept_bounds;
  const std::uint32_t* starts;
  const std::uint32_t* numbers;
  bool has_groups;
  std::uint32_t next = 0;  // swept bound whose pairs come next
  SpherePair* pairs;
  std::size_t room;
  std::size_t count = 0;
};

struct Run {
  std::uint32_t first, end;
};

template <class Numbers>
auto row_of(Numbers& numbers) {
  return VectorRow(numbers.data(), std::span(numbers));
}

/// Whether all pairs of the grid are between cells next to each other, counted along one line
/// through all cells: there is one level, which does not repeat, its voxels are wider than two
/// swept bounds extend, and steps along that line are distinct.
bool is_plain(const proto::GridShape& shape) {
  if (shape.level_count != 1) return false;
  const proto::GridLevel& level = shape.levels[0];
  float farthest = 0.0F;  // in voxels; rounding shifts a border by less than 2.4e-7 of it
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t low = level.lowest_voxel[axis], high = level.highest_voxel[axis];
    if (high - low >= level.cells[axis]) return false;
    farthest = std::max(farthest, static_cast<float>(std::max(std::abs(low), std::abs(high))));
  }
  return level.cells[0] >= 3 && level.cells[1] >= 3 &&
         2.0F * level.bounding_radius_m * (1.0F + kBoundSlack) <=
             level.voxel_m * (1.0F - 5e-7F * (farthest + 1.0F));
}

}  // namespace
}  // namespace stillgrid::contact
#endif

HWY_BEFORE_NAMESPACE();
namespace stillgrid::contact::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::CappedTag<float, kLanes>;

/// Transposes the sorted swept bounds and notes their cells.
void Unpack(const collision::GridView& view, SortedBounds& to) {
  const FloatTag d;
  const hn::RebindToSigned<FloatTag> di;
  const auto* words = reinterpret_cast<const float*>(view.words);
  const VectorRow<const float> from(
      words + 2 * view.layout.swept_bounds,
      {words, 2 * (view.layout.total_words + collision::kSparedWords)});
  const proto::GridLevel& level = view.shape.levels[0];
  const auto inverse = hn::Set(d, 1.0F / level.voxel_m);
  const auto stride_y = hn::Set(di, static_cast<std::int32_t>(level.cells[0]));
  const auto stride_z = hn::Set(di, static_cast<std::int32_t>(level.cells[0] * level.cells[1]));
  const auto voxel = [&](auto c_m, std::size_t axis) HWY_ATTR {
    const auto exact = hn::Mul(c_m, inverse);
    const auto whole = hn::ConvertTo(di, exact);  // towards zero
    const auto above = hn::Gt(hn::ConvertTo(d, whole), exact);
    return hn::Sub(hn::Add(whole, hn::BitCast(di, hn::VecFromMask(d, above))),
                   hn::Set(di, level.lowest_voxel[axis]));
  };
  // Whole vectors: the arrays have room for one beyond the last swept bound, and so do the grid's
  // words.
  for (std::size_t i = 0; i < view.shape.sphere_count; i += hn::Lanes(d)) {
    hn::Vec<FloatTag> x, y, z, bounding_radius;
    hn::LoadInterleaved4(d, from.at(i, 4), x, y, z, bounding_radius);
    hn::StoreU(x, d, row_of(to.x_m).at(i));
    hn::StoreU(y, d, row_of(to.y_m).at(i));
    hn::StoreU(z, d, row_of(to.z_m).at(i));
    hn::StoreU(bounding_radius, d, row_of(to.bounding_radius_m).at(i));
    const auto cell = hn::Add(
        voxel(x, 0), hn::Add(hn::Mul(stride_y, voxel(y, 1)), hn::Mul(stride_z, voxel(z, 2))));
    hn::StoreU(cell, di, reinterpret_cast<std::int32_t*>(row_of(to.cell).at(i)));
  }
}

/// One swept bound against others, kBounds at a time. It keeps numbers, for a vector may have no
/// size that the compiler knows (SVE).
class Looker {
 public:
  Looker(const SortedBounds& swept_bounds, std::uint32_t i)
      : swept_bounds_(swept_bounds),
        x_(swept_bounds.x_m[i]),
        y_(swept_bounds.y_m[i]),
        z_(swept_bounds.z_m[i]),
        bounding_radius_(swept_bounds.bounding_radius_m[i]) {}

  /// Bit k: swept bound first + k meets this one. Looks at kBounds swept bounds, whatever they are.
  HWY_INLINE std::uint32_t Meeting(std::uint32_t first) const {
    const FloatTag d;
    const auto load = [&](const std::vector<float>& numbers, std::uint32_t k)
                          HWY_ATTR { return hn::LoadU(d, (row_of(numbers) + first).at(k)); };
    std::uint32_t bits = 0;
    for (std::uint32_t k = 0; k < kBounds; k += static_cast<std::uint32_t>(hn::Lanes(d))) {
      const auto x = hn::Sub(load(swept_bounds_.x_m, k), hn::Set(d, x_));
      const auto y = hn::Sub(load(swept_bounds_.y_m, k), hn::Set(d, y_));
      const auto z = hn::Sub(load(swept_bounds_.z_m, k), hn::Set(d, z_));
      const auto bounding_radius =
          hn::Add(load(swept_bounds_.bounding_radius_m, k), hn::Set(d, bounding_radius_));
      const auto distance2 = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
      std::uint8_t lanes[8];
      hn::StoreMaskBits(d, hn::Le(distance2, hn::Mul(bounding_radius, bounding_radius)), lanes);
      bits |= static_cast<std::uint32_t>(lanes[0]) << k;
    }
    return bits;
  }

 private:
  const SortedBounds& swept_bounds_;
  float x_, y_, z_, bounding_radius_;
};

/// Whether the swept bound whose pairs are looked for and that at `place` are of one group.
HWY_INLINE bool AreOfOneGroup(const Search& search, std::uint32_t place) {
  if (!search.has_groups) return false;
  const std::uint32_t group = search.swept_bounds.group[search.next];
  return group != kNoGroup && search.swept_bounds.group[place] == group;
}

HWY_INLINE void AddPair(Search& search, std::uint32_t own, std::uint32_t place) {
  if (AreOfOneGroup(search, place)) return;
  const std::uint32_t other = search.numbers[place];
  search.pairs[search.count++] = {std::min(own, other), std::max(own, other)};
}

/// All that meet within one run, of any length. False for want of room.
HWY_INLINE bool SearchRun(Search& search, const Looker& looker, std::uint32_t own, Run run) {
  for (std::uint32_t first = run.first; first < run.end; first += kBounds) {
    if (AreOfOneGroup(search, first)) {
      first = search.swept_bounds.group_end[first];
      if (first >= run.end) break;
    }
    if (search.count + kBounds > search.room) return false;
    std::uint32_t bits = looker.Meeting(first);
    if (run.end - first < kBounds) bits &= (1U << (run.end - first)) - 1U;
    for (; bits != 0; bits &= bits - 1)
      AddPair(search, own, first + static_cast<std::uint32_t>(std::countr_zero(bits)));
  }
  return true;
}

/// Pairs of a plain grid, of the swept bounds before `end`: a swept bound with those after it in
/// its own cell and with those of the 13 cells that follow, which stand in five runs. False for
/// want of room. may_pass_end: some of these runs lie beyond the last cell.
template <bool may_pass_end>
bool SearchPlain(Search& search, std::uint32_t end) {
  const proto::GridLevel& level = search.view.shape.levels[0];
  const std::uint32_t row = level.cells[0], layer = row * level.cells[1];
  const std::uint32_t last = layer * level.cells[2];
  const auto start_of = [&](std::uint32_t cell) {
    return search.starts[may_pass_end ? std::min(cell, last) : cell];
  };
  for (; search.next < end; ++search.next) {
    const std::uint32_t i = search.next, cell = search.swept_bounds.cell[i];
    const std::uint32_t own = search.numbers[i];
    const Looker looker(search.swept_bounds, i);
    std::uint32_t firsts[5], longest = 0;
    std::uint64_t bits = 0;
    const auto look = [&](std::uint32_t r, std::uint32_t first, std::uint32_t stop) HWY_ATTR {
      firsts[r] = first;
      const std::uint32_t length = stop - first;
      longest = std::max(longest, length);
      const std::uint32_t valid = (1U << std::min(length, kBounds)) - 1U;
      bits |= std::uint64_t{looker.Meeting(first) & valid} << (8 * r);
    };
    look(0, i + 1, start_of(cell + 2));
    look(1, start_of(cell + row - 1), start_of(cell + row + 2));
    look(2, start_of(cell + layer - row - 1), start_of(cell + layer - row + 2));
    look(3, start_of(cell + layer - 1), start_of(cell + layer + 2));
    look(4, start_of(cell + layer + row - 1), start_of(cell + layer + row + 2));
    if (HWY_UNLIKELY(longest > kBounds)) {
      const std::size_t before = search.count;
      const std::uint32_t steps[4] = {row, layer - row, layer, layer + row};
      bool has_room = SearchRun(search, looker, own, {i + 1, start_of(cell + 2)});
      for (const std::uint32_t step : steps)
        has_room = has_room && SearchRun(search, looker, own,
                                         {start_of(cell + step - 1), start_of(cell + step + 2)});
      if (has_room) continue;
      search.count = before;
      return false;
    }
    if (HWY_UNLIKELY(search.count + 5 * kBounds > search.room)) return false;
    for (; bits != 0; bits &= bits - 1) {
      const int bit = std::countr_zero(bits);
      AddPair(search, own, firsts[bit / 8] + static_cast<std::uint32_t>(bit % 8));
    }
  }
  return true;
}

bool SearchPlainGrid(Search& search) {
  const proto::GridLevel& level = search.view.shape.levels[0];
  const std::uint32_t row = level.cells[0], layer = row * level.cells[1];
  const std::uint32_t last = layer * level.cells[2], farthest = layer + row + 2;
  const std::uint32_t inside = last > farthest ? search.starts[last - farthest] : 0;
  return SearchPlain<false>(search, inside) &&
         SearchPlain<true>(search, search.view.shape.sphere_count);
}

/// The pairs of one swept bound with those of a level: all, or those after it in its own.
bool SearchLevel(Search& search, const Looker& looker, const proto::GridLevel& level, bool is_own) {
  const std::uint32_t i = search.next, own = search.numbers[i];
  const std::array<float, 3> centre_m{search.swept_bounds.x_m[i], search.swept_bounds.y_m[i],
                                      search.swept_bounds.z_m[i]};
  const float bounding_radius_m =
      (search.swept_bounds.bounding_radius_m[i] + level.bounding_radius_m) * (1.0F + kBoundSlack);
  const collision::CellBlock block =
      collision::cell_block(level, centre_m, bounding_radius_m, 1.0F / level.voxel_m);
  if (block.is_empty) return true;
  const std::uint32_t first_x = block.first[0], count_x = block.count[0], cells_x = block.cells[0];
  const std::uint32_t straight = std::min(count_x, cells_x - first_x);
  const auto at = [&](int axis, std::uint32_t k) {
    const std::uint32_t cell = block.first[axis] + k;
    return cell < block.cells[axis] ? cell : cell - block.cells[axis];
  };
  const auto search_cells = [&](std::uint32_t first, std::uint32_t end) HWY_ATTR {
    Run run{search.starts[first], search.starts[end]};
    if (is_own) run.first = std::max(run.first, i + 1);
    return SearchRun(search, looker, own, run);
  };
  for (std::uint32_t k = 0; k < block.count[2]; ++k)
    for (std::uint32_t j = 0; j < block.count[1]; ++j) {
      const std::uint32_t row = level.first_cell + cells_x * (at(1, j) + block.cells[1] * at(2, k));
      if (!search_cells(row + first_x, row + first_x + straight)) return false;
      if (straight < count_x && !search_cells(row, row + (count_x - straight))) return false;
    }
  return true;
}

/// Pairs of any grid: a swept bound with those of all coarser levels, and with those after it in
/// its own.
bool SearchAny(Search& search) {
  const proto::GridShape& shape = search.view.shape;
  const auto level_end = [&](std::uint32_t level) {
    return level + 1 < shape.level_count ? search.starts[shape.levels[level + 1].first_cell]
                                         : shape.sphere_count;
  };
  std::uint32_t own_level = 0;
  for (; search.next < shape.sphere_count; ++search.next) {
    while (search.next >= level_end(own_level)) ++own_level;
    const Looker looker(search.swept_bounds, search.next);
    const std::size_t before = search.count;
    for (std::uint32_t level = 0; level <= own_level; ++level)
      if (!SearchLevel(search, looker, shape.levels[level], level == own_level)) {
        search.count = before;
        return false;
      }
  }
  return true;
}

}  // namespace stillgrid::contact::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillgrid::contact {
namespace {
HWY_EXPORT(Unpack);
HWY_EXPORT(SearchPlainGrid);
HWY_EXPORT(SearchAny);

/// Notes the groups of the sorted swept bounds.
void sort_groups(std::span<const std::uint32_t> groups, const std::uint32_t* numbers,
                 std::uint32_t count, SortedBounds& sorted) {
  sorted.group.resize(count);
  sorted.group_end.resize(count);
  for (std::uint32_t i = count; i-- > 0;) {
    const std::uint32_t group = sorted.group[i] = groups[numbers[i]];
    const bool goes_on = i + 1 < count && group != kNoGroup && sorted.group[i + 1] == group;
    sorted.group_end[i] = goes_on ? sorted.group_end[i + 1] : i + 1;
  }
}

}  // namespace

SortedBounds::SortedBounds(std::size_t capacity)
    : x_m(capacity + kBounds),
      y_m(capacity + kBounds),
      z_m(capacity + kBounds),
      bounding_radius_m(capacity + kBounds),
      cell(capacity + kBounds) {}

std::size_t search_pairs(const collision::GridView& view, std::span<const std::uint32_t> groups,
                         std::size_t most, SortedBounds& sorted, std::vector<SpherePair>& pairs) {
  if (view.shape.sphere_count < 2) return 0;
  HWY_DYNAMIC_DISPATCH(Unpack)(view, sorted);
  const auto* numbers = reinterpret_cast<const std::uint32_t*>(view.words + view.layout.numbers);
  if (!groups.empty()) sort_groups(groups, numbers, view.shape.sphere_count, sorted);
  const bool plain = is_plain(view.shape);
  Search search{view,
                sorted,
                reinterpret_cast<const std::uint32_t*>(view.words + view.layout.cell_starts),
                numbers,
                !groups.empty(),
                0,
                pairs.data(),
                pairs.size()};
  while (!(plain ? HWY_DYNAMIC_DISPATCH(SearchPlainGrid)(search)
                 : HWY_DYNAMIC_DISPATCH(SearchAny)(search))) {
    if (search.count > most) break;
    pairs.resize(2 * pairs.size() + 64 * kBounds);
    search.pairs = pairs.data();
    search.room = pairs.size();
  }
  return search.count;
}

}  // namespace stillgrid::contact
#endif
