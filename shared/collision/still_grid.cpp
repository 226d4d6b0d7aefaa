#include "shared/collision/still_grid.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

#include "shared/collision/grid_query.hpp"

namespace stillgrid {
namespace {

constexpr std::size_t kRecordWords = sizeof(proto::SphereRecord) / 8;

std::size_t words_for_u32(std::size_t count) {
  return (count + 1) / 2;
}

using VoxelBox = std::array<std::array<std::int32_t, 3>, 2>;  // lowest, highest

VoxelBox voxels_of(const Box& box, float inverse_voxel_per_m) {
  VoxelBox voxels{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    voxels[0][axis] = voxel_index(box.low_m[axis], inverse_voxel_per_m);
    voxels[1][axis] = voxel_index(box.high_m[axis], inverse_voxel_per_m);
  }
  return voxels;
}

/// Fewest cells per axis that hold the extent without repeating, or less where the capacity says
/// so.
std::array<std::uint32_t, 3> cells_for(const std::array<std::int64_t, 3>& extent_voxels,
                                       std::uint32_t log2_capacity) {
  std::array<std::uint32_t, 3> log2_cells{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto extent = static_cast<std::uint64_t>(std::max<std::int64_t>(extent_voxels[axis], 1));
    log2_cells[axis] = static_cast<std::uint32_t>(std::bit_width(extent - 1));
  }
  while (log2_cells[0] + log2_cells[1] + log2_cells[2] > log2_capacity)
    --*std::max_element(log2_cells.begin(), log2_cells.end());
  return log2_cells;
}

bool is_long(const VoxelBox& voxels, const std::array<std::uint32_t, 3>& log2_cells) {
  std::uint64_t count = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto span =
        static_cast<std::uint64_t>(std::int64_t{voxels[1][axis]} - voxels[0][axis] + 1);
    // A box wider than the period would enter a cell twice.
    if (span > (std::uint64_t{1} << log2_cells[axis])) return true;
    count *= std::min<std::uint64_t>(span, proto::kMaxVoxelsPerSphere + 1);
  }
  return count > proto::kMaxVoxelsPerSphere;
}

template <class Visit>
void for_each_cell(const std::array<std::int32_t, 3>& low, const std::array<std::int32_t, 3>& high,
                   const std::array<std::uint32_t, 3>& log2_cells, Visit&& visit) {
  for (std::int32_t z = low[2]; z <= high[2]; ++z)
    for (std::int32_t y = low[1]; y <= high[1]; ++y)
      for (std::int32_t x = low[0]; x <= high[0]; ++x) visit(cell_of({x, y, z}, log2_cells));
}

}  // namespace

GridLayout grid_layout(std::size_t header_bytes, std::size_t sphere_capacity,
                       std::uint32_t log2_cell_capacity) {
  GridLayout layout;
  layout.sphere_capacity = sphere_capacity;
  layout.log2_cell_capacity = log2_cell_capacity;
  layout.records = (header_bytes + 63) / 64 * 8;
  layout.cell_starts = layout.records + sphere_capacity * kRecordWords;
  layout.entries = layout.cell_starts + words_for_u32((std::size_t{1} << log2_cell_capacity) + 1);
  layout.long_list = layout.entries + words_for_u32(sphere_capacity * proto::kMaxVoxelsPerSphere);
  layout.total_words = layout.long_list + words_for_u32(sphere_capacity);
  return layout;
}

std::uint32_t log2_cells_for(std::size_t sphere_count) {
  return static_cast<std::uint32_t>(
      std::bit_width(std::max<std::size_t>(4 * sphere_count, 64) - 1));
}

bool is_consistent(const proto::GridShape& shape, const GridLayout& layout) noexcept {
  if (!(shape.voxel_m > 0.0F) || !std::isfinite(1.0F / shape.voxel_m)) return false;
  std::uint64_t log2_sum = 0;
  for (const std::uint32_t log2_cells : shape.log2_cells) log2_sum += log2_cells;
  return log2_sum <= layout.log2_cell_capacity && shape.sphere_count <= layout.sphere_capacity &&
         shape.long_count <= shape.sphere_count &&
         shape.entry_count <= std::uint64_t{shape.sphere_count} * proto::kMaxVoxelsPerSphere;
}

Box box_round(const Eigen::Vector3d& centre_m, double radius_m) noexcept {
  const Eigen::Vector3f low = (centre_m.array() - radius_m).cast<float>();
  const Eigen::Vector3f high = (centre_m.array() + radius_m).cast<float>();
  return {{low.x(), low.y(), low.z()}, {high.x(), high.y(), high.z()}};
}

Box swept_box(const proto::SphereRecord& record) noexcept {
  Box box{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto [low, high] =
        std::minmax({record.newest[0].position_m[axis], record.newest[1].position_m[axis],
                     record.older[0].position_m[axis], record.older[1].position_m[axis]});
    box.low_m[axis] = low - record.radius_m;
    box.high_m[axis] = high + record.radius_m;
  }
  return box;
}

StillGrid::StillGrid(std::size_t header_bytes, std::size_t sphere_capacity)
    : layout_(grid_layout(header_bytes, sphere_capacity, log2_cells_for(sphere_capacity))),
      words_(layout_.total_words, 0),
      highest_voxel_(sphere_capacity) {}

std::span<proto::SphereRecord> StillGrid::records() noexcept {
  return {reinterpret_cast<proto::SphereRecord*>(words_.data() + layout_.records),
          layout_.sphere_capacity};
}

std::uint32_t* StillGrid::u32_at(std::size_t word) noexcept {
  return reinterpret_cast<std::uint32_t*>(words_.data() + word);
}

void StillGrid::fill(std::size_t sphere_count, float voxel_m) {
  assert(sphere_count <= layout_.sphere_capacity && voxel_m > 0.0F);
  const auto spheres = records().first(sphere_count);
  const float inverse_voxel_per_m = 1.0F / voxel_m;

  std::array<std::int64_t, 3> low{}, high{};
  low.fill(std::numeric_limits<std::int32_t>::max());
  high.fill(std::numeric_limits<std::int32_t>::min());
  for (std::size_t i = 0; i < sphere_count; ++i) {
    const VoxelBox voxels = voxels_of(swept_box(spheres[i]), inverse_voxel_per_m);
    spheres[i].lowest_voxel = voxels[0];
    highest_voxel_[i] = voxels[1];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min<std::int64_t>(low[axis], voxels[0][axis]);
      high[axis] = std::max<std::int64_t>(high[axis], voxels[1][axis]);
    }
  }

  shape_ = {};
  shape_.voxel_m = voxel_m;
  shape_.sphere_count = static_cast<std::uint32_t>(sphere_count);
  shape_.log2_cells = cells_for({high[0] - low[0] + 1, high[1] - low[1] + 1, high[2] - low[2] + 1},
                                layout_.log2_cell_capacity);

  const auto& log2_cells = shape_.log2_cells;
  const std::size_t cells = std::size_t{1} << (log2_cells[0] + log2_cells[1] + log2_cells[2]);
  std::uint32_t* starts = u32_at(layout_.cell_starts);
  std::uint32_t* entries = u32_at(layout_.entries);
  std::uint32_t* long_list = u32_at(layout_.long_list);

  std::fill_n(starts, cells + 1, 0U);
  for (std::size_t i = 0; i < sphere_count; ++i) {
    if (is_long({spheres[i].lowest_voxel, highest_voxel_[i]}, log2_cells)) {
      long_list[shape_.long_count++] = static_cast<std::uint32_t>(i);
      highest_voxel_[i][2] = std::numeric_limits<std::int32_t>::min();  // no layers below
      continue;
    }
    for_each_cell(spheres[i].lowest_voxel, highest_voxel_[i], log2_cells,
                  [&](std::size_t cell) { ++starts[cell]; });
  }
  for (std::size_t cell = 0; cell < cells; ++cell) {
    shape_.entry_count += starts[cell];
    starts[cell] = shape_.entry_count;
  }
  starts[cells] = shape_.entry_count;
  // Backwards, so that each start ends where its cell begins and entries ascend.
  for (std::size_t i = sphere_count; i-- > 0;)
    for_each_cell(spheres[i].lowest_voxel, highest_voxel_[i], log2_cells, [&](std::size_t cell) {
      entries[--starts[cell]] = static_cast<std::uint32_t>(i);
    });
}

GridView StillGrid::view() const noexcept {
  return {shape_, layout_, words_.data()};
}

std::array<PayloadPart, 4> StillGrid::filled_parts() const noexcept {
  const std::size_t cells = std::size_t{1}
                            << (shape_.log2_cells[0] + shape_.log2_cells[1] + shape_.log2_cells[2]);
  const std::span<const std::uint64_t> all(words_);
  const auto part = [&](std::size_t first, std::size_t count) {
    return PayloadPart{first, all.subspan(first, count)};
  };
  return {part(layout_.records, shape_.sphere_count * kRecordWords),
          part(layout_.cell_starts, words_for_u32(cells + 1)),
          part(layout_.entries, words_for_u32(shape_.entry_count)),
          part(layout_.long_list, words_for_u32(shape_.long_count))};
}

}  // namespace stillgrid
