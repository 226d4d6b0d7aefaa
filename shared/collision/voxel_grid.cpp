#include "shared/collision/voxel_grid.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "shared/collision/grid_levels.hpp"
#include "shared/collision/grid_query.hpp"
#include "shared/collision/sphere_history.hpp"

namespace stillgrid::collision {
namespace {

constexpr std::size_t kRecordWords = sizeof(proto::SphereRecord) / 8;

std::size_t words_for_u32(std::size_t count) {
  return (count + 1) / 2;
}

using Four = Eigen::Array4f;

/// A swept bound as four floats: centre, then radius.
Eigen::Map<const Four> four(const SweptBound& swept_bound) {
  return Eigen::Map<const Four>(swept_bound.centre_m.data());
}

/// The least and the greatest of some swept bounds' centres and reaches.
struct Bounds {
  Four low = Four::Constant(std::numeric_limits<float>::max());
  Four high = Four::Constant(std::numeric_limits<float>::lowest());
  void include(const Four& swept_bound) {
    low = low.min(swept_bound);
    high = high.max(swept_bound);
  }
};

[[noreturn]] void refuse(std::span<const SweptBound> swept_bounds) {
  std::size_t i = 0;
  while (four(swept_bounds[i]).isFinite().all() && swept_bounds[i].bounding_radius_m > 0.0F) ++i;
  const auto& [c, bounding_radius_m] = swept_bounds[i];
  throw std::domain_error("sphere " + std::to_string(i) + " is nowhere: its swept bound at " +
                          std::to_string(c[0]) + ", " + std::to_string(c[1]) + ", " +
                          std::to_string(c[2]) + " m reaches " + std::to_string(bounding_radius_m) +
                          " m: expected finite numbers");
}

/// Bounds of all. Throws at a swept bound that is none.
Bounds bounds_of(std::span<const SweptBound> swept_bounds) {
  Bounds bounds;
  Four nothing = Four::Zero();  // no number, once one of them is none
  for (const SweptBound& swept_bound : swept_bounds) {
    bounds.include(four(swept_bound));
    nothing += four(swept_bound) * 0.0F;
  }
  if (!nothing.isFinite().all() || !(bounds.low[3] > 0.0F)) refuse(swept_bounds);
  return bounds;
}

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
  [[nodiscard]] std::uint32_t operator()(const SweptBound& swept_bound) const {
    const Int4 voxel = voxel_index(std::bit_cast<Float4>(swept_bound), inverse_voxel_per_m);
    // Unsigned: what is as far apart as voxels can be is 2^31 of them.
    const Unsigned4 at =
        (std::bit_cast<Unsigned4>(voxel) - std::bit_cast<Unsigned4>(lowest)) & mask;
    return first_cell + at[0] + row * at[1] + layer * at[2];
  }
};

}  // namespace

GridLayout grid_layout(std::size_t header_bytes, std::size_t sphere_capacity) {
  GridLayout layout;
  layout.sphere_capacity = sphere_capacity;
  layout.cell_capacity = kCellsPerSphere * sphere_capacity + kLeastCells * proto::kMaxLevels;
  layout.records = (header_bytes + 63) / 64 * 8;
  layout.cell_starts = layout.records + sphere_capacity * kRecordWords;
  layout.swept_bounds = layout.cell_starts + (words_for_u32(layout.cell_capacity + 1) + 7) / 8 * 8;
  layout.numbers = layout.swept_bounds + (sphere_capacity + kBoundsAtOnce - 1) * 2;
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

VoxelGrid::VoxelGrid(std::size_t header_bytes, std::size_t sphere_capacity)
    : layout_(grid_layout(header_bytes, sphere_capacity)),
      words_(layout_.total_words + kSparedWords, 0),
      level_of_(sphere_capacity),
      place_of_(sphere_capacity) {}

std::span<proto::SphereRecord> VoxelGrid::records() noexcept {
  return {reinterpret_cast<proto::SphereRecord*>(words_.data() + layout_.records),
          layout_.sphere_capacity};
}

std::span<const proto::SphereRecord> VoxelGrid::records() const noexcept {
  return {reinterpret_cast<const proto::SphereRecord*>(words_.data() + layout_.records),
          layout_.sphere_capacity};
}

std::uint32_t* VoxelGrid::u32_at(std::size_t word) noexcept {
  return reinterpret_cast<std::uint32_t*>(words_.data() + word);
}

void VoxelGrid::push_snapshot(std::span<const proto::SphereState> snapshots) noexcept {
  assert(snapshots.size() == layout_.sphere_capacity);
  const auto spheres = records();
  for (std::size_t i = 0; i < snapshots.size(); ++i) {
    if (has_snapshot_)
      collision::push_snapshot(spheres[i], snapshots[i]);
    else
      fill_history(spheres[i], snapshots[i]);
  }
  has_snapshot_ = true;
}

void VoxelGrid::enter(std::span<const SweptBound> swept_bounds, float voxel_ratio,
                      std::uint32_t octaves) {
  assert(swept_bounds.size() <= layout_.sphere_capacity && voxel_ratio > 0.0F && octaves > 0);
  shape_levels(swept_bounds, voxel_ratio, octaves);
  sort_bounds(swept_bounds);
}

/// Levels, the level of each sphere, and the cells that each level takes.
void VoxelGrid::shape_levels(std::span<const SweptBound> swept_bounds, float voxel_ratio,
                             std::uint32_t octaves_a_level) {
  std::array<Bounds, proto::kMaxLevels> bounds;
  std::array<std::size_t, proto::kMaxLevels> spheres{};
  if (!swept_bounds.empty())
    bounds[0] = bounds_of(swept_bounds);  // throws before anything is changed
  shape_ = {};
  shape_.sphere_count = static_cast<std::uint32_t>(swept_bounds.size());
  if (swept_bounds.empty()) return;

  shape_.level_count = 1;
  spheres[0] = swept_bounds.size();
  const Octaves octaves(bounds[0].high[3], bounds[0].low[3], octaves_a_level);
  if (octaves.most() > 0) {
    std::array<std::size_t, proto::kMaxLevels> count{};
    for (std::size_t i = 0; i < swept_bounds.size(); ++i) {
      level_of_[i] = octaves.of(swept_bounds[i].bounding_radius_m);
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
    for (std::size_t i = 0; i < swept_bounds.size(); ++i) {
      level_of_[i] = level_of_octave[level_of_[i]];
      bounds[level_of_[i]].include(four(swept_bounds[i]));
    }
  }

  std::uint64_t first_cell = 0;
  for (std::uint32_t i = 0; i < shape_.level_count; ++i) {
    proto::GridLevel& level = shape_.levels[i];
    level.bounding_radius_m = bounds[i].high[3];
    level.voxel_m = 2.0F * voxel_ratio * level.bounding_radius_m;
    const float inverse_voxel_per_m = 1.0F / level.voxel_m;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto k = static_cast<Eigen::Index>(axis);
      level.lowest_voxel[axis] = voxel_index(bounds[i].low[k], inverse_voxel_per_m);
      level.highest_voxel[axis] = voxel_index(bounds[i].high[k], inverse_voxel_per_m);
    }
    level.cells = cells_for(level, spheres[i]);
    level.first_cell = static_cast<std::uint32_t>(first_cell);
    first_cell += cell_count(level);
  }
  assert(first_cell <= layout_.cell_capacity);
}

/// Counting sort of the swept bounds by cell.
void VoxelGrid::sort_bounds(std::span<const SweptBound> swept_bounds) {
  std::uint32_t* starts = u32_at(layout_.cell_starts);
  std::size_t cells = 0;
  for (std::uint32_t i = 0; i < shape_.level_count; ++i) {
    cells += cell_count(shape_.levels[i]);
  }
  std::fill_n(starts, cells + 1, 0U);
  const auto count = [&](std::size_t i, const CellOf& cell_of_level) {
    place_of_[i] = cell_of_level(swept_bounds[i]);
    ++starts[place_of_[i]];
  };
  std::array<CellOf, proto::kMaxLevels> cell_of;
  for (std::uint32_t i = 0; i < shape_.level_count; ++i) cell_of[i] = CellOf(shape_.levels[i]);
  if (shape_.level_count == 1)
    for (std::size_t i = 0; i < swept_bounds.size(); ++i) count(i, cell_of[0]);
  else
    for (std::size_t i = 0; i < swept_bounds.size(); ++i) count(i, cell_of[level_of_[i]]);
  std::uint32_t sum = 0;
  for (std::size_t cell = 0; cell <= cells; ++cell) {
    sum += starts[cell];
    starts[cell] = sum;
  }
  auto* sorted = reinterpret_cast<SweptBound*>(words_.data() + layout_.swept_bounds);
  std::uint32_t* numbers = u32_at(layout_.numbers);
  // Backwards, so that each start ends where its cell begins and numbers ascend.
  for (std::size_t i = swept_bounds.size(); i-- > 0;) {
    const std::uint32_t place = --starts[place_of_[i]];
    place_of_[i] = place;
    sorted[place] = swept_bounds[i];
    numbers[place] = static_cast<std::uint32_t>(i);
  }
}

void VoxelGrid::grow(std::size_t sphere, float bounding_radius_m) noexcept {
  float& level_radius_m =
      reinterpret_cast<SweptBound*>(words_.data() + layout_.swept_bounds)[place_of_[sphere]]
          .bounding_radius_m;
  level_radius_m = std::max(level_radius_m, bounding_radius_m);
  float& level_m = shape_.levels[shape_.level_count > 1 ? level_of_[sphere] : 0].bounding_radius_m;
  level_m = std::max(level_m, bounding_radius_m);
}

const SweptBound& VoxelGrid::swept_bound(std::size_t sphere) const noexcept {
  return sorted_bounds()[place_of_[sphere]];
}

GridView VoxelGrid::view() const noexcept {
  return {shape_, layout_, words_.data()};
}

std::span<const SweptBound> VoxelGrid::sorted_bounds() const noexcept {
  return {reinterpret_cast<const SweptBound*>(words_.data() + layout_.swept_bounds),
          shape_.sphere_count};
}

std::span<const std::uint32_t> VoxelGrid::sorted_numbers() const noexcept {
  return {reinterpret_cast<const std::uint32_t*>(words_.data() + layout_.numbers),
          shape_.sphere_count};
}

std::array<double_buffer::PayloadPart, 4> VoxelGrid::filled_parts() const noexcept {
  std::size_t cells = 0;
  for (std::uint32_t i = 0; i < shape_.level_count; ++i) cells += cell_count(shape_.levels[i]);
  const std::span<const std::uint64_t> all(words_.data(), layout_.total_words);
  const auto part = [&](std::size_t first, std::size_t count) {
    return double_buffer::PayloadPart{first, all.subspan(first, count)};
  };
  return {part(layout_.records, shape_.sphere_count * kRecordWords),
          part(layout_.cell_starts, words_for_u32(cells + 1)),
          part(layout_.swept_bounds, std::size_t{2} * shape_.sphere_count),
          part(layout_.numbers, words_for_u32(shape_.sphere_count))};
}

}  // namespace stillgrid::collision
