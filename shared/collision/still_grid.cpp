#include "shared/collision/still_grid.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "shared/collision/grid_query.hpp"
#include "shared/collision/sphere_history.hpp"

namespace stillgrid {
namespace {

constexpr std::size_t kRecordWords = sizeof(proto::SphereRecord) / 8;

/// Cells that a level may take for each of its spheres, and at least.
constexpr std::size_t kCellsPerSphere = 8, kLeastCells = 64;

std::size_t words_for_u32(std::size_t count) {
  return (count + 1) / 2;
}

std::uint64_t extent_voxels(const proto::GridLevel& level, std::size_t axis) {
  return static_cast<std::uint64_t>(std::int64_t{level.highest_voxel[axis]} -
                                    level.lowest_voxel[axis] + 1);
}

std::uint64_t cell_count(const proto::GridLevel& level) {
  return std::uint64_t{level.cells[0]} * level.cells[1] * level.cells[2];
}

/// A cell for each voxel of the extent, or, along the longest axes, a power of two that repeats.
std::array<std::uint32_t, 3> cells_for(const proto::GridLevel& level, std::size_t most_cells) {
  std::array<std::uint64_t, 3> cells{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    cells[axis] = std::min<std::uint64_t>(extent_voxels(level, axis), std::uint64_t{1} << 31U);
  const auto fits = [&] {
    return static_cast<double>(cells[0]) * static_cast<double>(cells[1]) *
               static_cast<double>(cells[2]) <=
           static_cast<double>(most_cells);
  };
  while (!fits()) {
    auto& longest = *std::max_element(cells.begin(), cells.end());
    longest = std::bit_floor(longest - 1);
  }
  return {static_cast<std::uint32_t>(cells[0]), static_cast<std::uint32_t>(cells[1]),
          static_cast<std::uint32_t>(cells[2])};
}

bool is_consistent_level(const proto::GridLevel& level, std::size_t cell_capacity) {
  if (!(level.voxel_m > 0.0F) || !std::isfinite(1.0F / level.voxel_m) || !(level.reach_m >= 0.0F) ||
      !std::isfinite(level.reach_m))
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

using Four = Eigen::Array4f;

/// A cover as four floats: centre, then reach.
Eigen::Map<const Four> four(const Cover& cover) {
  return Eigen::Map<const Four>(cover.centre_m.data());
}

/// The least and the greatest of some covers' centres and reaches.
struct Bounds {
  Four low = Four::Constant(std::numeric_limits<float>::max());
  Four high = Four::Constant(std::numeric_limits<float>::lowest());
  void include(const Four& cover) {
    low = low.min(cover);
    high = high.max(cover);
  }
};

[[noreturn]] void refuse(std::span<const Cover> covers) {
  std::size_t i = 0;
  while (four(covers[i]).isFinite().all() && covers[i].reach_m > 0.0F) ++i;
  const auto& [c, reach_m] = covers[i];
  throw std::domain_error("sphere " + std::to_string(i) + " is nowhere: its cover at " +
                          std::to_string(c[0]) + ", " + std::to_string(c[1]) + ", " +
                          std::to_string(c[2]) + " m reaches " + std::to_string(reach_m) +
                          " m: expected finite numbers");
}

/// Bounds of all. Throws at a cover that is none.
Bounds bounds_of(std::span<const Cover> covers) {
  Bounds bounds;
  Four nothing = Four::Zero();  // no number, once one of them is none
  for (const Cover& cover : covers) {
    bounds.include(four(cover));
    nothing += four(cover) * 0.0F;
  }
  if (!nothing.isFinite().all() || !(bounds.low[3] > 0.0F)) refuse(covers);
  return bounds;
}

/// The octave of a reach, counted from the longest; wider than an octave where eight do not do.
class Octaves {
 public:
  Octaves(float longest_m, float shortest_m)
      : longest_m_(longest_m), most_(octaves_below(shortest_m)) {}
  [[nodiscard]] std::uint32_t most() const { return std::min(most_, proto::kMaxLevels - 1); }
  [[nodiscard]] std::uint8_t of(float reach_m) const {
    const std::uint32_t octaves = octaves_below(reach_m);
    return static_cast<std::uint8_t>(
        most_ < proto::kMaxLevels ? octaves : octaves * (proto::kMaxLevels - 1) / most_);
  }

 private:
  /// The whole part of log2(longest / reach), which is the exponent of the quotient.
  [[nodiscard]] std::uint32_t octaves_below(float reach_m) const {
    constexpr std::uint32_t kMantissaBits = 23, kBias = 127;
    const float quotient = std::min(longest_m_ / reach_m, std::numeric_limits<float>::max());
    return (std::bit_cast<std::uint32_t>(quotient) >> kMantissaBits) - kBias;
  }

  float longest_m_;
  std::uint32_t most_;
};

/// How a level turns a centre into a cell.
struct CellOf {
  float inverse_voxel_per_m = 0.0F;
  Int4 lowest{};
  Unsigned4 mask{};  // of the cells, along an axis that repeats
  std::uint32_t first_cell = 0, row = 0, layer = 0;

  CellOf() = default;
  explicit CellOf(const proto::GridLevel& level)
      : inverse_voxel_per_m(1.0F / level.voxel_m),
        first_cell(level.first_cell),
        row(level.cells[0]),
        layer(level.cells[0] * level.cells[1]) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lowest[axis] = level.lowest_voxel[axis];
      mask[axis] = extent_voxels(level, axis) > level.cells[axis] ? level.cells[axis] - 1 : ~0U;
    }
  }

  /// As cell_block() has it.
  [[nodiscard]] std::uint32_t operator()(const Cover& cover) const {
    const Int4 voxel = voxel_index(std::bit_cast<Float4>(cover), inverse_voxel_per_m);
    // Unsigned: what is as far apart as voxels can be is 2^31 of them.
    const Unsigned4 at =
        (std::bit_cast<Unsigned4>(voxel) - std::bit_cast<Unsigned4>(lowest)) & mask;
    return first_cell + at[0] + row * at[1] + layer * at[2];
  }
};

/// A level below this many spheres joins the coarser one: looking into it would cost more.
constexpr std::size_t kFewSpheres = 16;

}  // namespace

GridLayout grid_layout(std::size_t header_bytes, std::size_t sphere_capacity) {
  GridLayout layout;
  layout.sphere_capacity = sphere_capacity;
  layout.cell_capacity = kCellsPerSphere * sphere_capacity + kLeastCells * proto::kMaxLevels;
  layout.records = (header_bytes + 63) / 64 * 8;
  layout.cell_starts = layout.records + sphere_capacity * kRecordWords;
  layout.covers = layout.cell_starts + (words_for_u32(layout.cell_capacity + 1) + 7) / 8 * 8;
  layout.numbers = layout.covers + (sphere_capacity + kCoversAtOnce - 1) * 2;
  layout.total_words = layout.numbers + words_for_u32(sphere_capacity);
  return layout;
}

bool is_consistent(const proto::GridShape& shape, const GridLayout& layout) noexcept {
  if (shape.sphere_count > layout.sphere_capacity || shape.level_count > proto::kMaxLevels)
    return false;
  for (std::uint32_t i = 0; i < shape.level_count; ++i)
    if (!is_consistent_level(shape.levels[i], layout.cell_capacity)) return false;
  return true;
}

StillGrid::StillGrid(std::size_t header_bytes, std::size_t sphere_capacity)
    : layout_(grid_layout(header_bytes, sphere_capacity)),
      words_(layout_.total_words + kSparedWords, 0),
      level_of_(sphere_capacity),
      place_of_(sphere_capacity) {}

std::span<proto::SphereRecord> StillGrid::records() noexcept {
  return {reinterpret_cast<proto::SphereRecord*>(words_.data() + layout_.records),
          layout_.sphere_capacity};
}

std::span<const proto::SphereRecord> StillGrid::records() const noexcept {
  return {reinterpret_cast<const proto::SphereRecord*>(words_.data() + layout_.records),
          layout_.sphere_capacity};
}

std::uint32_t* StillGrid::u32_at(std::size_t word) noexcept {
  return reinterpret_cast<std::uint32_t*>(words_.data() + word);
}

void StillGrid::push_image(std::span<const proto::SphereImage> images) noexcept {
  assert(images.size() == layout_.sphere_capacity);
  const auto spheres = records();
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (has_image_)
      stillgrid::push_image(spheres[i], images[i]);
    else
      fill_history(spheres[i], images[i]);
  }
  has_image_ = true;
}

void StillGrid::enter(std::span<const Cover> covers, float voxel_ratio) {
  assert(covers.size() <= layout_.sphere_capacity && voxel_ratio > 0.0F);
  shape_levels(covers, voxel_ratio);
  sort_covers(covers);
}

/// Levels, the level of each sphere, and the cells that each level takes.
void StillGrid::shape_levels(std::span<const Cover> covers, float voxel_ratio) {
  std::array<Bounds, proto::kMaxLevels> bounds;
  std::array<std::size_t, proto::kMaxLevels> spheres{};
  if (!covers.empty()) bounds[0] = bounds_of(covers);  // throws before anything is changed
  shape_ = {};
  shape_.sphere_count = static_cast<std::uint32_t>(covers.size());
  if (covers.empty()) return;

  shape_.level_count = 1;
  spheres[0] = covers.size();
  const Octaves octaves(bounds[0].high[3], bounds[0].low[3]);
  if (octaves.most() > 0) {
    std::array<std::size_t, proto::kMaxLevels> count{};
    for (std::size_t i = 0; i < covers.size(); ++i) {
      level_of_[i] = octaves.of(covers[i].reach_m);
      ++count[level_of_[i]];
    }
    // From octaves, many of them empty, to levels, coarse to fine.
    std::array<std::uint8_t, proto::kMaxLevels> level_of_octave{};
    spheres[0] = count[0];
    for (std::size_t octave = 1; octave < count.size(); ++octave) {
      if (count[octave] >= kFewSpheres) ++shape_.level_count;
      level_of_octave[octave] = static_cast<std::uint8_t>(shape_.level_count - 1);
      spheres[shape_.level_count - 1] += count[octave];
    }
    bounds.fill({});
    for (std::size_t i = 0; i < covers.size(); ++i) {
      level_of_[i] = level_of_octave[level_of_[i]];
      bounds[level_of_[i]].include(four(covers[i]));
    }
  }

  std::uint64_t first_cell = 0;
  for (std::uint32_t i = 0; i < shape_.level_count; ++i) {
    proto::GridLevel& level = shape_.levels[i];
    level.reach_m = bounds[i].high[3];
    level.voxel_m = 2.0F * voxel_ratio * level.reach_m;
    const float inverse_voxel_per_m = 1.0F / level.voxel_m;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto k = static_cast<Eigen::Index>(axis);
      level.lowest_voxel[axis] = voxel_index(bounds[i].low[k], inverse_voxel_per_m);
      level.highest_voxel[axis] = voxel_index(bounds[i].high[k], inverse_voxel_per_m);
    }
    level.cells = cells_for(level, std::max(kCellsPerSphere * spheres[i], kLeastCells));
    level.first_cell = static_cast<std::uint32_t>(first_cell);
    first_cell += cell_count(level);
  }
  assert(first_cell <= layout_.cell_capacity);
}

/// Counting sort of the covers by cell.
void StillGrid::sort_covers(std::span<const Cover> covers) {
  std::uint32_t* starts = u32_at(layout_.cell_starts);
  std::size_t cells = 0;
  for (std::uint32_t i = 0; i < shape_.level_count; ++i) {
    cells += cell_count(shape_.levels[i]);
  }
  std::fill_n(starts, cells + 1, 0U);
  const auto count = [&](std::size_t i, const CellOf& cell_of_level) {
    place_of_[i] = cell_of_level(covers[i]);
    ++starts[place_of_[i]];
  };
  std::array<CellOf, proto::kMaxLevels> cell_of;
  for (std::uint32_t i = 0; i < shape_.level_count; ++i) cell_of[i] = CellOf(shape_.levels[i]);
  if (shape_.level_count == 1)
    for (std::size_t i = 0; i < covers.size(); ++i) count(i, cell_of[0]);
  else
    for (std::size_t i = 0; i < covers.size(); ++i) count(i, cell_of[level_of_[i]]);
  std::uint32_t sum = 0;
  for (std::size_t cell = 0; cell <= cells; ++cell) {
    sum += starts[cell];
    starts[cell] = sum;
  }
  auto* sorted = reinterpret_cast<Cover*>(words_.data() + layout_.covers);
  std::uint32_t* numbers = u32_at(layout_.numbers);
  // Backwards, so that each start ends where its cell begins and numbers ascend.
  for (std::size_t i = covers.size(); i-- > 0;) {
    const std::uint32_t place = --starts[place_of_[i]];
    place_of_[i] = place;
    sorted[place] = covers[i];
    numbers[place] = static_cast<std::uint32_t>(i);
  }
}

void StillGrid::grow(std::size_t sphere, float reach_m) noexcept {
  float& cover_m =
      reinterpret_cast<Cover*>(words_.data() + layout_.covers)[place_of_[sphere]].reach_m;
  cover_m = std::max(cover_m, reach_m);
  float& level_m = shape_.levels[shape_.level_count > 1 ? level_of_[sphere] : 0].reach_m;
  level_m = std::max(level_m, reach_m);
}

const Cover& StillGrid::cover(std::size_t sphere) const noexcept {
  return sorted_covers()[place_of_[sphere]];
}

GridView StillGrid::view() const noexcept {
  return {shape_, layout_, words_.data()};
}

std::span<const Cover> StillGrid::sorted_covers() const noexcept {
  return {reinterpret_cast<const Cover*>(words_.data() + layout_.covers), shape_.sphere_count};
}

std::span<const std::uint32_t> StillGrid::sorted_numbers() const noexcept {
  return {reinterpret_cast<const std::uint32_t*>(words_.data() + layout_.numbers),
          shape_.sphere_count};
}

std::array<PayloadPart, 4> StillGrid::filled_parts() const noexcept {
  std::size_t cells = 0;
  for (std::uint32_t i = 0; i < shape_.level_count; ++i) cells += cell_count(shape_.levels[i]);
  const std::span<const std::uint64_t> all(words_.data(), layout_.total_words);
  const auto part = [&](std::size_t first, std::size_t count) {
    return PayloadPart{first, all.subspan(first, count)};
  };
  return {part(layout_.records, shape_.sphere_count * kRecordWords),
          part(layout_.cell_starts, words_for_u32(cells + 1)),
          part(layout_.covers, std::size_t{2} * shape_.sphere_count),
          part(layout_.numbers, words_for_u32(shape_.sphere_count))};
}

}  // namespace stillgrid
