#include "tests/performance/paper_grid.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid::performance {

template <class Stamp>
PaperGrid<Stamp>::PaperGrid(float voxel_m, const std::array<std::uint32_t, 3>& cells,
                            Stamp first_stamp)
    : inverse_voxel_per_m_(1.0F / voxel_m),
      cells_(cells),
      voxels_(std::size_t{cells[0]} * cells[1] * cells[2]),
      check_(first_stamp) {}

template <class Stamp>
template <class Visit>
void PaperGrid<Stamp>::for_each_voxel(const collision::SweptBound& ball, Visit&& visit) {
  std::array<std::uint32_t, 3> low, count;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto voxel = [&](float x_m) {
      return static_cast<std::int64_t>(std::floor(x_m * inverse_voxel_per_m_));
    };
    const std::int64_t first = voxel(ball.centre_m[axis] - ball.bounding_radius_m);
    const std::int64_t last = voxel(ball.centre_m[axis] + ball.bounding_radius_m);
    const std::int64_t cells = cells_[axis];
    low[axis] = static_cast<std::uint32_t>((first % cells + cells) % cells);
    count[axis] = static_cast<std::uint32_t>(std::min(last - first + 1, cells));
  }
  const auto at = [&](std::size_t axis, std::uint32_t i) {
    const std::uint32_t cell = low[axis] + i;
    return cell < cells_[axis] ? cell : cell - cells_[axis];
  };
  for (std::uint32_t k = 0; k < count[2]; ++k)
    for (std::uint32_t j = 0; j < count[1]; ++j)
      for (std::uint32_t i = 0; i < count[0]; ++i)
        visit(voxels_[at(0, i) + std::size_t{cells_[0]} * (at(1, j) + cells_[1] * at(2, k))]);
}

template <class Stamp>
void PaperGrid<Stamp>::put(std::uint32_t sphere, std::uint32_t& first,
                           std::vector<Entry>& entries) {
  entries.push_back({sphere, first});
  first = static_cast<std::uint32_t>(entries.size() - 1);
}

template <class Stamp>
void PaperGrid<Stamp>::enter_static(std::span<const collision::SweptBound> balls) {
  for (const collision::SweptBound& ball : balls) {
    const auto number = static_cast<std::uint32_t>(static_.size());
    static_.push_back(ball);
    for_each_voxel(ball,
                   [&](VoxelList& voxel) { put(number, voxel.first_static, static_entries_); });
  }
}

template <class Stamp>
PaperCounts PaperGrid<Stamp>::find(std::span<const collision::SweptBound> balls,
                                   std::vector<contact::SpherePair>& pairs) {
  const auto moving = static_cast<std::uint32_t>(balls.size());
  tested_.resize(balls.size() + static_.size());
  entries_.clear();
  pairs.clear();
  ++step_;
  PaperCounts counts;
  for (std::uint32_t i = 0; i < moving; ++i) {
    ++check_;
    const auto check = [&](std::uint32_t j, const collision::SweptBound& other) {
      ++counts.visits;
      if (tested_[j] == check_) return;
      tested_[j] = check_;
      ++counts.tests;
      const auto &p = balls[i].centre_m, &q = other.centre_m;
      const float x = p[0] - q[0], y = p[1] - q[1], z = p[2] - q[2];
      const float bounding_radius_m = balls[i].bounding_radius_m + other.bounding_radius_m;
      if (x * x + y * y + z * z < bounding_radius_m * bounding_radius_m)
        pairs.push_back({std::min(i, j), std::max(i, j)});
    };
    for_each_voxel(balls[i], [&](VoxelList& voxel) {
      if (voxel.stamp != step_) {
        voxel.stamp = step_;
        voxel.first = kNone;
      }
      for (std::uint32_t e = voxel.first; e != kNone; e = entries_[e].next)
        check(entries_[e].sphere, balls[entries_[e].sphere]);
      for (std::uint32_t e = voxel.first_static; e != kNone; e = static_entries_[e].next)
        check(moving + static_entries_[e].sphere, static_[static_entries_[e].sphere]);
      put(i, voxel.first, entries_);
    });
  }
  counts.entries = entries_.size();
  return counts;
}

template class PaperGrid<std::uint16_t>;
template class PaperGrid<std::uint32_t>;
template class PaperGrid<std::uint64_t>;

}  // namespace stillgrid::performance
