#include "shared/collision/touch_lists.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "shared/collision/grid_levels.hpp"

namespace stillgrid::collision {
namespace {

/// Edge of a voxel over the greatest radius and probe radius together that its level holds: a wider
/// one makes lists longer, a narrower one makes more of them.
constexpr float kVoxelOverExtent = 1.0F;

/// Voxels are as wide at least as that part of how far they are from the origin: else what rounding
/// adds to a small sphere that is far away would put it into many.
constexpr float kVoxelOverDistance = 1e-6F;

/// A sphere to be listed: round its centre, as far as what touches it may have its own.
struct Listed {
  const proto::SphereRecord* record;
  float extent_m;
  float voxel_m;  // that it needs
  std::uint32_t level;
  [[nodiscard]] const std::array<float, 3>& centre_m() const { return record->newest.position_m; }
  [[nodiscard]] VoxelBox voxels(const proto::GridLevel& shape) const {
    return voxel_box(centre_m(), extent_m, 1.0F / shape.voxel_m);
  }
};

std::vector<Listed> listed_spheres(std::span<const proto::SphereRecord> spheres,
                                   float probe_radius_m) {
  std::vector<Listed> listed;
  for (const proto::SphereRecord& record : spheres) {
    const auto& p = record.newest.position_m;
    if (std::isnan(p[0]) || std::isnan(p[1]) || std::isnan(p[2])) continue;
    constexpr float kOutwards = 1.0F + 1e-6F;
    const float extent_m = (record.radius_m + probe_radius_m) * kOutwards;
    const float away_m = std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
    listed.push_back(
        {&record, extent_m, std::max(kVoxelOverExtent * extent_m, kVoxelOverDistance * away_m), 0});
  }
  return listed;
}

/// Gives each sphere its level; returns how many spheres each level has.
std::vector<std::size_t> choose_levels(std::vector<Listed>& listed) {
  const auto [least, most] =
      std::minmax_element(listed.begin(), listed.end(),
                          [](const Listed& a, const Listed& b) { return a.voxel_m < b.voxel_m; });
  const Octaves octaves(most->voxel_m, least->voxel_m, 1);
  std::array<std::size_t, proto::kMaxLevels> count{};
  for (Listed& sphere : listed) ++count[sphere.level = octaves.of(sphere.voxel_m)];
  std::vector<std::size_t> spheres{count[0]};
  std::array<std::uint32_t, proto::kMaxLevels> level_of_octave{};
  for (std::size_t octave = 1; octave < count.size(); ++octave) {
    if (count[octave] >= kFewSpheres) spheres.push_back(0);
    spheres.back() += count[octave];
    level_of_octave[octave] = static_cast<std::uint32_t>(spheres.size() - 1);
  }
  for (Listed& sphere : listed) sphere.level = level_of_octave[sphere.level];
  return spheres;
}

void shape_levels(std::vector<Listed>& listed, proto::TouchShape& shape) {
  const std::vector<std::size_t> spheres = choose_levels(listed);
  shape.level_count = static_cast<std::uint32_t>(spheres.size());
  for (std::size_t k = 0; k < spheres.size(); ++k) {
    proto::GridLevel& level = shape.levels[k];
    for (const Listed& sphere : listed) {
      if (sphere.level != k) continue;
      level.bounding_radius_m = std::max(level.bounding_radius_m, sphere.extent_m);
      level.voxel_m = std::max(level.voxel_m, sphere.voxel_m);
    }
    level.lowest_voxel.fill(std::numeric_limits<std::int32_t>::max());
    level.highest_voxel.fill(std::numeric_limits<std::int32_t>::min());
    for (const Listed& sphere : listed) {
      if (sphere.level != k) continue;
      const VoxelBox box = sphere.voxels(level);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        level.lowest_voxel[axis] = std::min(level.lowest_voxel[axis], box.lowest[axis]);
        level.highest_voxel[axis] = std::max(level.highest_voxel[axis], box.highest[axis]);
      }
    }
    level.cells = cells_for(level, spheres[k]);
    level.first_cell = shape.cell_count;
    shape.cell_count += static_cast<std::uint32_t>(cell_count(level));
  }
}

/// The part of a voxel's distance from a sphere's centre that is along one axis, squared; rounding
/// may have put up to that much more of space into the voxel.
double apart2_m2(double voxel_m, std::int32_t voxel, float centre_m) {
  const double slack = 1e-6 * (std::abs(static_cast<double>(voxel)) + 2.0);
  const double low_m = voxel_m * (voxel - slack), high_m = voxel_m * (voxel + 1.0 + slack);
  const double apart_m = std::max({0.0, low_m - double{centre_m}, double{centre_m} - high_m});
  return apart_m * apart_m;
}

/// The voxels of a sphere's box along one axis: where their cells are, and how far from its centre.
struct AxisVoxels {
  static constexpr std::uint32_t kMaxVoxels = 4;  // for none extends farther than a voxel is wide
  std::uint32_t count = 0;
  bool is_whole = false;  // all cells of the axis, more than once round: none is far
  std::array<std::uint32_t, kMaxVoxels> cell{};
  std::array<double, kMaxVoxels> apart2_m2{};
};

AxisVoxels axis_voxels(const proto::GridLevel& level, const VoxelBox& box, std::size_t axis,
                       float centre_m) {
  const std::int64_t voxels = std::int64_t{box.highest[axis]} - box.lowest[axis] + 1;
  assert(voxels <= AxisVoxels::kMaxVoxels);
  AxisVoxels along;
  along.is_whole = voxels > level.cells[axis];
  along.count = static_cast<std::uint32_t>(
      std::min({voxels, std::int64_t{level.cells[axis]}, std::int64_t{AxisVoxels::kMaxVoxels}}));
  for (std::uint32_t k = 0; k < along.count; ++k) {
    const std::int64_t voxel = std::int64_t{box.lowest[axis]} + k;
    along.cell[k] =
        static_cast<std::uint32_t>((voxel - level.lowest_voxel[axis]) % level.cells[axis]);
    along.apart2_m2[k] =
        apart2_m2(double{level.voxel_m}, static_cast<std::int32_t>(voxel), centre_m);
  }
  return along;
}

/// Calls visit(cell) once for each cell of the sphere's level where a centre may be that is no
/// farther from its own than it extends.
template <class Visit>
void for_each_cell(const proto::GridLevel& level, const Listed& sphere, Visit&& visit) {
  const VoxelBox box = sphere.voxels(level);
  std::array<AxisVoxels, 3> along;
  for (std::size_t axis = 0; axis < 3; ++axis)
    along[axis] = axis_voxels(level, box, axis, sphere.centre_m()[axis]);
  const auto& [x, y, z] = along;
  const bool is_whole = x.is_whole || y.is_whole || z.is_whole;
  const double extent2_m2 = 1.00001 * double{sphere.extent_m} * double{sphere.extent_m};
  for (std::uint32_t k = 0; k < z.count; ++k)
    for (std::uint32_t j = 0; j < y.count; ++j)
      for (std::uint32_t i = 0; i < x.count; ++i)
        if (is_whole || x.apart2_m2[i] + y.apart2_m2[j] + z.apart2_m2[k] <= extent2_m2)
          visit(level.first_cell + x.cell[i] +
                level.cells[0] * (y.cell[j] + level.cells[1] * z.cell[k]));
}

/// Writes each sphere into its lists, in their order. starts: of each cell's list.
void write_lists(const std::vector<Listed>& listed, std::span<const proto::SphereRecord> spheres,
                 const std::vector<std::uint64_t>& starts, std::uint64_t* entries,
                 const proto::TouchShape& shape) {
  const auto write = [&](std::size_t cell, std::size_t i, const std::array<float, 3>& centre_m,
                         float radius_m, const proto::TouchLabel& label) {
    const std::size_t count = starts[cell + 1] - starts[cell];
    std::uint64_t* const list = entries + kTouchEntryWords * starts[cell];
    auto* const numbers = reinterpret_cast<float*>(list);
    for (std::size_t axis = 0; axis < 3; ++axis) numbers[axis * count + i] = centre_m[axis];
    numbers[3 * count + i] = radius_m;
    reinterpret_cast<proto::TouchLabel*>(list + 2 * count)[i] = label;
  };
  std::vector<std::uint32_t> written(shape.cell_count);
  for (const Listed& sphere : listed) {
    const proto::SphereRecord& record = *sphere.record;
    const auto number = static_cast<std::uint32_t>(sphere.record - spheres.data());
    for_each_cell(shape.levels[sphere.level], sphere, [&](std::uint32_t cell) {
      write(cell, written[cell]++, sphere.centre_m(), record.radius_m,
            {number, record.material, record.body, 0});
    });
  }
  constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t cell = 0; cell < written.size(); ++cell)
    if (starts[cell] + written[cell] < starts[cell + 1])
      write(cell, written[cell], {kNowhere, kNowhere, kNowhere}, 0.0F,
            {std::numeric_limits<std::uint32_t>::max(), 0, 0, 0});
}

}  // namespace

std::size_t touch_entry_word(const proto::TouchShape& shape) noexcept {
  return ((std::size_t{shape.cell_count} + 1) * 4 + 63) / 64 * 8;
}

std::size_t touch_words(const proto::TouchShape& shape) noexcept {
  return touch_entry_word(shape) + kTouchEntryWords * std::size_t{shape.entry_count};
}

bool is_consistent(const proto::TouchShape& shape) noexcept {
  if (shape.level_count > proto::kMaxLevels || !(shape.probe_radius_m > 0.0F) ||
      !std::isfinite(shape.probe_radius_m))
    return false;
  for (std::uint32_t i = 0; i < shape.level_count; ++i)
    if (!is_consistent_level(shape.levels[i], shape.cell_count)) return false;
  return true;
}

TouchLists::TouchLists(std::span<const proto::SphereRecord> spheres, float probe_radius_m) {
  shape_.probe_radius_m = probe_radius_m;
  std::vector<Listed> listed = listed_spheres(spheres, probe_radius_m);
  if (!listed.empty()) shape_levels(listed, shape_);
  std::vector<std::uint64_t> starts(std::size_t{shape_.cell_count} + 1);
  for (const Listed& sphere : listed)
    for_each_cell(shape_.levels[sphere.level], sphere,
                  [&](std::uint32_t cell) { ++starts[cell + std::size_t{1}]; });
  for (std::size_t cell = 0; cell < shape_.cell_count; ++cell)
    starts[cell + 1] = starts[cell] + (starts[cell + 1] + 1) / 2 * 2;
  if (starts.back() > std::numeric_limits<std::uint32_t>::max())
    throw std::length_error("touch lists: expected fewer than 2^32 entries, not " +
                            std::to_string(starts.back()));
  shape_.entry_count = static_cast<std::uint32_t>(starts.back());
  words_.resize(touch_words(shape_));
  std::copy(starts.begin(), starts.end(), reinterpret_cast<std::uint32_t*>(words_.data()));
  write_lists(listed, spheres, starts, words_.data() + touch_entry_word(shape_), shape_);
}

TouchView::TouchView(const proto::TouchShape& shape, std::uint32_t sphere_count,
                     const std::uint64_t* words)
    : shape_(shape),
      sphere_count_(sphere_count),
      starts_(words),
      entries_(words + touch_entry_word(shape)) {
  for (std::size_t k = 0; k < shape.level_count; ++k) {
    const proto::GridLevel& level = shape.levels[k];
    Level& own = levels_[k];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      own.lowest[axis] = level.lowest_voxel[axis];
      own.highest[axis] = level.highest_voxel[axis];
      own.mask[axis] = extent_voxels(level, axis) > level.cells[axis] ? level.cells[axis] - 1 : ~0U;
    }
    own.inverse_voxel_per_m = 1.0F / level.voxel_m;
    own.first_cell = level.first_cell;
    own.row = level.cells[0];
    own.layer = level.cells[0] * level.cells[1];
  }
}

}  // namespace stillgrid::collision
