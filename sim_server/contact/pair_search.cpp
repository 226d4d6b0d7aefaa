#include "sim_server/contact/pair_search.hpp"

#include <algorithm>
#include <array>
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

/// Swept bounds that the widest look at a run of cells tests. Runs hold two to five: more lanes
/// than these cost more than they find.
constexpr std::uint32_t kBounds = kLanes;

/// Pairs found, by place among the sorted swept bounds: a few at a time, so that they stay in the
/// nearest cache, then all of them by number.
class FoundPairs {
 public:
  FoundPairs(const std::uint32_t* numbers, std::size_t most, std::vector<SpherePair>& pairs)
      : numbers_(numbers), most_(most), pairs_(pairs) {}

  /// Where the places of pair k of the few stand, with room for a whole vector while k is no more
  /// than kRoom.
  static constexpr std::size_t kRoom = 1024;
  [[nodiscard]] std::uint32_t* own(std::size_t k) { return owns_.data() + k; }
  [[nodiscard]] std::uint32_t* other(std::size_t k) { return others_.data() + k; }

  /// Takes over the first `few`.
  void write(std::size_t few) {
    if (pairs_.size() < count_ + few) pairs_.resize(2 * pairs_.size() + kRoom + kBounds);
    SpherePair* to = pairs_.data() + count_;
    for (std::size_t k = 0; k < few; ++k) {
      const std::uint32_t own = numbers_[owns_[k]], other = numbers_[others_[k]];
      to[k] = {std::min(own, other), std::max(own, other)};
    }
    count_ += few;
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] bool are_too_many() const { return count_ > most_; }

 private:
  const std::uint32_t* numbers_;
  std::size_t most_;
  std::vector<SpherePair>& pairs_;
  std::size_t count_ = 0;
  std::array<std::uint32_t, kRoom + 2 * kBounds> owns_, others_;
};

/// 0, 1, 2, ...: to be loaded, for Highway makes them anew each time.
alignas(64) constexpr std::array<std::int32_t, kBounds> kCounted = {0, 1, 2, 3, 4, 5, 6, 7};

/// Of each byte, the numbers of the bits that are set, ascending: what processors that cannot
/// compress a vector load instead.
constexpr auto kBitsSet = [] {
  std::array<std::array<std::uint8_t, 8>, 256> numbers{};
  for (std::size_t byte = 0; byte < numbers.size(); ++byte)
    for (std::uint8_t bit = 0, k = 0; bit < 8; ++bit)
      if (((byte >> bit) & 1U) != 0) numbers[byte][k++] = bit;
  return numbers;
}();

/// What is searched.
struct Search {
  const collision::GridView& view;
  const SortedBounds& swept_bounds;
  const std::uint32_t* starts;
  FoundPairs& found;
};

/// Swept bounds of neighbouring cells, by place.
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

/// One swept bound after the other against runs of them, a vector at a time. It keeps numbers, for
/// a vector may have no size that the compiler knows (SVE).
template <bool has_groups>
class Looker {
 public:
  explicit Looker(const Search& search)
      : search_(search),
        x_m_(row_of(search.swept_bounds.x_m)),
        y_m_(row_of(search.swept_bounds.y_m)),
        z_m_(row_of(search.swept_bounds.z_m)),
        bounding_radius_m_(row_of(search.swept_bounds.bounding_radius_m)),
        groups_(row_of(search.swept_bounds.group)) {}

  /// Turns to the swept bound at place i.
  HWY_INLINE void TurnTo(std::uint32_t i) {
    i_ = i;
    x_ = *x_m_.one(i);
    y_ = *y_m_.one(i);
    z_ = *z_m_.one(i);
    bounding_radius_ = *bounding_radius_m_.one(i);
    if (has_groups) group_ = *groups_.one(i);
  }
  [[nodiscard]] std::uint32_t place() const { return i_; }

  /// Finds all of a run that meet this one and are of no group with it. The first vector is looked
  /// at in any case: most runs end in it, so that the processor predicts the only branch.
  HWY_INLINE void Look(Run run) {
    const FloatTag d;
    const hn::RebindToSigned<FloatTag> di;
    do {
      if (has_groups && group_ != kNoGroup && run.first < run.end &&
          *groups_.one(run.first) == group_) {
        run.first = search_.swept_bounds.group_end[run.first];
        if (run.first >= run.end) break;
      }
      const auto places = hn::Add(hn::Load(di, kCounted.data()), Signed(run.first));
      const auto meeting =
          hn::And(Meeting(run.first), hn::RebindMask(d, hn::Lt(places, Signed(run.end))));
      few_ += StorePlaces(run.first, places, meeting,
                          reinterpret_cast<std::int32_t*>(search_.found.other(few_)));
      run.first += static_cast<std::uint32_t>(hn::Lanes(d));
      if (HWY_UNLIKELY(few_ > FoundPairs::kRoom)) Write();
    } while (HWY_UNLIKELY(run.first < run.end));
  }

  /// Notes the own place beside all that were found since the last time.
  HWY_INLINE void Name() {
    const hn::RebindToUnsigned<FloatTag> du;
    do {
      hn::StoreU(hn::Set(du, i_), du, search_.found.own(named_));
      named_ = std::min(named_ + hn::Lanes(du), few_);
    } while (HWY_UNLIKELY(named_ < few_));
  }

  HWY_NOINLINE void Write() {
    Name();
    search_.found.write(few_);
    named_ = few_ = 0;
  }

 private:
  using Row = VectorRow<const float>;

  /// Writes those places from `first` on whose lanes are set, side by side; returns how many.
  template <class Places>
  static HWY_INLINE std::size_t StorePlaces(std::uint32_t first, Places places,
                                            hn::Mask<FloatTag> lanes, std::int32_t* to) {
    const FloatTag d;
    const hn::RebindToSigned<FloatTag> di;
#if HWY_HAVE_SCALABLE || HWY_TARGET <= HWY_AVX3
    static_cast<void>(first);
    hn::StoreU(hn::Compress(places, hn::RebindMask(di, lanes)), di, to);
    return hn::CountTrue(d, lanes);
#else
    static_cast<void>(places);
    std::uint8_t bits[8];
    hn::StoreMaskBits(d, lanes, bits);
    const hn::Rebind<std::uint8_t, FloatTag> bytes;
    const auto set = hn::PromoteTo(di, hn::LoadU(bytes, kBitsSet[bits[0]].data()));
    hn::StoreU(hn::Add(set, Signed(first)), di, to);
    return static_cast<std::size_t>(std::popcount(bits[0]));
#endif
  }

  /// A place in every lane, of a kind that all processors compare.
  static HWY_INLINE auto Signed(std::uint32_t place) {
    return hn::Set(hn::RebindToSigned<FloatTag>(), static_cast<std::int32_t>(place));
  }

  HWY_INLINE hn::Mask<FloatTag> Meeting(std::uint32_t first) const {
    const FloatTag d;
    const auto load = [&](Row row) HWY_ATTR { return hn::LoadU(d, (row + first).at(0)); };
    const auto x = hn::Sub(load(x_m_), hn::Set(d, x_));
    const auto y = hn::Sub(load(y_m_), hn::Set(d, y_));
    const auto z = hn::Sub(load(z_m_), hn::Set(d, z_));
    const auto bounding_radius = hn::Add(load(bounding_radius_m_), hn::Set(d, bounding_radius_));
    const auto distance2 = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
    const auto meeting = hn::Le(distance2, hn::Mul(bounding_radius, bounding_radius));
    if (!has_groups || group_ == kNoGroup) return meeting;
    const hn::RebindToUnsigned<FloatTag> du;
    const auto group = hn::LoadU(du, (groups_ + first).at(0));
    return hn::AndNot(hn::RebindMask(d, hn::Eq(group, hn::Set(du, group_))), meeting);
  }

  const Search& search_;
  Row x_m_, y_m_, z_m_, bounding_radius_m_;
  VectorRow<const std::uint32_t> groups_;
  std::uint32_t i_ = 0;
  float x_ = 0.0F, y_ = 0.0F, z_ = 0.0F, bounding_radius_ = 0.0F;
  std::uint32_t group_ = kNoGroup;
  std::size_t few_ = 0, named_ = 0;  // pairs that are not written yet, and have both their places
};

/// Pairs of a plain grid, of the swept bounds [i, end): a swept bound with those after it in
/// its own cell and with those of the 13 cells that follow, which stand in five runs. may_pass_end:
/// some of these runs lie beyond the last cell.
template <bool may_pass_end, bool has_groups>
void SearchPlain(const Search& search, Looker<has_groups> looker, std::uint32_t i,
                 std::uint32_t end) {
  const proto::GridLevel& level = search.view.shape.levels[0];
  const std::uint32_t row = level.cells[0], layer = row * level.cells[1];
  const std::uint32_t last = layer * level.cells[2];
  const std::uint32_t* const starts = search.starts;
  const std::uint32_t* const cells = search.swept_bounds.cell.data();
  const auto start_of = [=](std::uint32_t cell) {
    return starts[may_pass_end ? std::min(cell, last) : cell];
  };
  const auto three_at = [=](std::uint32_t cell) {
    return Run{start_of(cell - 1), start_of(cell + 2)};
  };
  for (; i < end; ++i) {
    const std::uint32_t cell = cells[i];
    looker.TurnTo(i);
    looker.Look({i + 1, start_of(cell + 2)});
    looker.Look(three_at(cell + row));
    looker.Look(three_at(cell + layer - row));
    looker.Look(three_at(cell + layer));
    looker.Look(three_at(cell + layer + row));
    looker.Name();
    if (HWY_UNLIKELY(search.found.are_too_many())) break;
  }
  looker.Write();
}

template <bool has_groups>
void SearchPlainGrid(const Search& search) {
  const proto::GridLevel& level = search.view.shape.levels[0];
  const std::uint32_t row = level.cells[0], layer = row * level.cells[1];
  const std::uint32_t last = layer * level.cells[2], farthest = layer + row + 2;
  const std::uint32_t inside = last > farthest ? search.starts[last - farthest] : 0;
  const Looker<has_groups> looker(search);
  SearchPlain<false>(search, looker, 0, inside);
  SearchPlain<true>(search, looker, inside, search.view.shape.sphere_count);
}

/// The pairs of one swept bound with those of a level: all, or those after it in its own.
template <bool has_groups>
void SearchLevel(const Search& search, Looker<has_groups>& looker, const proto::GridLevel& level,
                 bool is_own) {
  const std::uint32_t i = looker.place();
  const std::array<float, 3> centre_m{search.swept_bounds.x_m[i], search.swept_bounds.y_m[i],
                                      search.swept_bounds.z_m[i]};
  const float bounding_radius_m =
      (search.swept_bounds.bounding_radius_m[i] + level.bounding_radius_m) * (1.0F + kBoundSlack);
  const collision::CellBlock block =
      collision::cell_block(level, centre_m, bounding_radius_m, 1.0F / level.voxel_m);
  if (block.is_empty) return;
  const std::uint32_t first_x = block.first[0], count_x = block.count[0], cells_x = block.cells[0];
  const std::uint32_t straight = std::min(count_x, cells_x - first_x);
  const auto at = [&](int axis, std::uint32_t k) {
    const std::uint32_t cell = block.first[axis] + k;
    return cell < block.cells[axis] ? cell : cell - block.cells[axis];
  };
  const auto search_cells = [&](std::uint32_t first, std::uint32_t end) HWY_ATTR {
    Run run{search.starts[first], search.starts[end]};
    if (is_own) run.first = std::max(run.first, i + 1);
    if (run.first < run.end) looker.Look(run);
  };
  for (std::uint32_t k = 0; k < block.count[2]; ++k)
    for (std::uint32_t j = 0; j < block.count[1]; ++j) {
      const std::uint32_t row = level.first_cell + cells_x * (at(1, j) + block.cells[1] * at(2, k));
      search_cells(row + first_x, row + first_x + straight);
      if (straight < count_x) search_cells(row, row + (count_x - straight));
    }
}

/// Pairs of any grid: a swept bound with those of all coarser levels, and with those after it in
/// its own.
template <bool has_groups>
void SearchAny(const Search& search) {
  const proto::GridShape& shape = search.view.shape;
  const auto level_end = [&](std::uint32_t level) {
    return level + 1 < shape.level_count ? search.starts[shape.levels[level + 1].first_cell]
                                         : shape.sphere_count;
  };
  std::uint32_t own_level = 0;
  Looker<has_groups> looker(search);
  for (std::uint32_t i = 0; i < shape.sphere_count && !search.found.are_too_many(); ++i) {
    while (i >= level_end(own_level)) ++own_level;
    looker.TurnTo(i);
    for (std::uint32_t level = 0; level <= own_level; ++level)
      SearchLevel(search, looker, shape.levels[level], level == own_level);
    looker.Name();
  }
  looker.Write();
}

void SearchGrid(const Search& search, bool has_groups) {
  const bool plain = is_plain(search.view.shape);
  if (has_groups)
    plain ? SearchPlainGrid<true>(search) : SearchAny<true>(search);
  else
    plain ? SearchPlainGrid<false>(search) : SearchAny<false>(search);
}

}  // namespace stillgrid::contact::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillgrid::contact {
namespace {
HWY_EXPORT(Unpack);
HWY_EXPORT(SearchGrid);

/// Notes the groups of the sorted swept bounds.
void sort_groups(std::span<const std::uint32_t> groups, const std::uint32_t* numbers,
                 std::uint32_t count, SortedBounds& sorted) {
  sorted.group.resize(count + kBounds);
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
  FoundPairs found(numbers, most, pairs);
  const auto* starts = reinterpret_cast<const std::uint32_t*>(view.words + view.layout.cell_starts);
  HWY_DYNAMIC_DISPATCH(SearchGrid)({view, sorted, starts, found}, !groups.empty());
  return found.count();
}

}  // namespace stillgrid::contact
#endif
