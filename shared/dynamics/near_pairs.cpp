#include "shared/dynamics/near_pairs.hpp"

// SVE has vectors of unknown size, whose masks have no fixed number of bytes.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2)
// One code for every instruction set that Highway knows; the best is chosen when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shared/dynamics/near_pairs.cpp"
#include <hwy/foreach_target.h>  // first: highway.h depends on it
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Finds the pairs of the places first .. end - 1 with later ones. Returns how many it compared.
std::int64_t SearchCells(const NearPairs::Cells& cells, std::int32_t first, std::int32_t end,
                         std::vector<NearPair>& pairs) {
  const hn::CappedTag<float, 16> d;
  const auto lanes = static_cast<std::int32_t>(hn::Lanes(d));
  const std::int32_t row = cells.count[2], slab = cells.count[1] * row;
  const std::int32_t *const start = cells.start.data(), *const cell = cells.cell.data();
  const float *const x = cells.x.data(), *const y = cells.y.data(), *const z = cells.z.data();
  const float* const radius = cells.radius.data();
  const std::int32_t still = cells.count[0] * slab;  // the cells of balls that never move
  const int ranges = static_cast<std::size_t>(still) + 1 < cells.start.size() ? 14 : 5;
  std::int64_t compared = 0;
  for (std::int32_t i = first; i < end; ++i) {
    const auto xi = hn::Set(d, x[i]), yi = hn::Set(d, y[i]), zi = hn::Set(d, z[i]);
    const auto ri = hn::Set(d, radius[i]);
    const std::int32_t c = cell[i];
    // The rest of its own cell and the next; then three cells of each of four rows of cells.
    std::int32_t firsts[14] = {i + 1, start[c + row - 1], start[c + slab - row - 1],
                               start[c + slab - 1], start[c + slab + row - 1]};
    std::int32_t ends[14] = {start[c + 2], start[c + row + 2], start[c + slab - row + 2],
                             start[c + slab + 2], start[c + slab + row + 2]};
    // All 27 cells around it of balls that never move.
    for (int range = 5; range < ranges; ++range) {
      const std::int32_t middle =
          still + c + ((range - 5) / 3 - 1) * slab + ((range - 5) % 3 - 1) * row;
      firsts[range] = start[middle - 1];
      ends[range] = start[middle + 2];
    }
    for (int range = 0; range < ranges; ++range) {
      compared += ends[range] - firsts[range];
      for (std::int32_t j = firsts[range]; j < ends[range]; j += lanes) {
        const auto dx = hn::Sub(hn::LoadU(d, x + j), xi), dy = hn::Sub(hn::LoadU(d, y + j), yi);
        const auto dz = hn::Sub(hn::LoadU(d, z + j), zi),
                   sum = hn::Add(hn::LoadU(d, radius + j), ri);
        const auto square = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
        const auto hit = hn::Lt(square, hn::Mul(sum, sum));
        if (hn::AllFalse(d, hit)) continue;
        std::uint8_t bytes[8] = {};
        hn::StoreMaskBits(d, hit, bytes);
        std::uint64_t bits = 0;
        std::memcpy(&bits, bytes, sizeof bits);
        const std::int32_t left = ends[range] - j;
        if (left < lanes) bits &= (std::uint64_t{1} << left) - 1;
        for (; bits != 0; bits &= bits - 1) pairs.push_back({i, j + std::countr_zero(bits)});
      }
    }
  }
  return compared;
}

}  // namespace stillgrid::dynamics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillgrid::dynamics {

HWY_EXPORT(SearchCells);

namespace {

constexpr std::size_t kPadding = 16;      // lanes of the widest vector
constexpr double kFarthest_m = 1e12;      // what is farther does not shape the grid
constexpr double kRounding = 1e-6;        // of floats, as a share of the extent of the grid
constexpr int kMaxCellsPerAxis = 1 << 9;  // so that their product is an int

double axis(const Vector4& v, int k) {
  return k == 0 ? v.x : k == 1 ? v.y : v.z;
}

/// Mean and three standard deviations along an axis, twice without what is farther out.
std::pair<double, double> bulk(std::span<const Vector4> balls, int k) {
  double low = -kFarthest_m, high = kFarthest_m, mean = 0.0, wide = 0.0;
  for (int pass = 0; pass < 3; ++pass) {
    double sum = 0.0, squares = 0.0, count = 0.0;
    const double middle = mean;
    for (const Vector4& ball : balls) {
      const double x = axis(ball, k) - middle;
      if (!(x + middle >= low && x + middle <= high)) continue;  // or is no number
      sum += x, squares += x * x, count += 1.0;
    }
    if (count == 0.0) break;
    mean = middle + sum / count;
    wide = 3.0 * std::sqrt(std::max(0.0, squares / count - sum / count * (sum / count)));
    low = mean - wide, high = mean + wide;
  }
  return {mean, wide};
}

}  // namespace

void NearPairs::choose_grid(std::span<const Vector4> balls) {
  largest_m_ = 0.0;
  for (const Vector4& ball : balls) largest_m_ = std::max(largest_m_, ball.w);
  width_m_ = std::max(2.0 * largest_m_, 1e-9);
  std::array<double, 3> extent{};
  for (int k = 0; k < 3; ++k) {
    const auto [mean, wide] = bulk(balls, k);
    corner_m_[static_cast<std::size_t>(k)] = mean - wide;
    extent[static_cast<std::size_t>(k)] = 2.0 * wide;
  }
  const std::size_t most = 4 * balls.size() + 64;
  cells_.start.reserve(2 * most + 1);
  const auto along = [&](std::size_t k) {
    return static_cast<int>(std::min<double>(kMaxCellsPerAxis - 4, extent[k] / width_m_)) + 3;
  };
  while (true) {
    const double cells = double(along(0)) * double(along(1)) * double(along(2));
    if (cells <= static_cast<double>(most)) break;
    width_m_ *= 1.25;
  }
  width_m_ *= 1.0 + kRounding;
  for (std::size_t k = 0; k < 3; ++k) cells_.count[k] = along(k);
}

/// Balls beyond the grid are counted to its outermost cells.
int NearPairs::cell_along(double coordinate_m, std::size_t axis) const {
  const double cell = (coordinate_m - corner_m_[axis]) / width_m_;
  return cell > 0.0 ? 1 + static_cast<int>(std::min<double>(cell, cells_.count[axis] - 3)) : 1;
}

void NearPairs::append_near(const Vector4& ball, std::vector<std::int32_t>& places) const {
  each_place(ball, (1.0 + kRounding) * (ball.w + largest_m_),
             [&](std::int32_t place) { places.push_back(place); });
}

void NearPairs::sort_into_cells(std::span<const Vector4> balls, std::size_t still) {
  const std::size_t n = balls.size();
  const auto& count = cells_.count;
  const std::int32_t cells = count[0] * count[1] * count[2];
  next_.resize(n);
  cells_.start.assign(static_cast<std::size_t>(cells) * (still > 0 ? 2 : 1) + 1, 0);
  for (std::size_t i = 0; i < n; ++i) {
    next_[i] = (cell_along(balls[i].x, 0) * count[1] + cell_along(balls[i].y, 1)) * count[2] +
               cell_along(balls[i].z, 2) + (i < n - still ? 0 : cells);
    ++cells_.start[static_cast<std::size_t>(next_[i]) + 1];
  }
  for (std::size_t k = 1; k < cells_.start.size(); ++k) cells_.start[k] += cells_.start[k - 1];
  order_.resize(n);
  cells_.cell.resize(n);
  // Each cell's start counts up to its end, which is the start of the next: then all shift by one.
  for (std::size_t i = 0; i < n; ++i) {
    const auto place = static_cast<std::size_t>(cells_.start[static_cast<std::size_t>(next_[i])]++);
    order_[place] = static_cast<std::int32_t>(i);
    cells_.cell[place] = next_[i];
  }
  std::copy_backward(cells_.start.begin(), cells_.start.end() - 1, cells_.start.end());
  cells_.start.front() = 0;
}

void NearPairs::arrange(std::span<const Vector4> balls) {
  choose_grid(balls);
  sort_into_cells(balls, 0);
}

void NearPairs::find(std::span<const Vector4> balls, std::size_t still,
                     const WorkSharing& sharing) {
  choose_grid(balls);
  sort_into_cells(balls, still);
  const std::size_t n = balls.size(), padded = n + kPadding;
  for (auto* values : {&cells_.x, &cells_.y, &cells_.z, &cells_.radius}) values->resize(padded);
  double extent = 0.0;
  for (std::size_t k = 0; k < 3; ++k) extent = std::max(extent, width_m_ * cells_.count[k]);
  for (std::size_t place = 0; place < n; ++place) {
    const Vector4& ball = balls[static_cast<std::size_t>(order_[place])];
    cells_.x[place] = static_cast<float>(ball.x - corner_m_[0]);
    cells_.y[place] = static_cast<float>(ball.y - corner_m_[1]);
    cells_.z[place] = static_cast<float>(ball.z - corner_m_[2]);
    cells_.radius[place] = static_cast<float>(ball.w + kRounding * extent);
  }
  search(n - still, sharing);
}

/// Pairs of all parts follow each other as one search would have found them.
void NearPairs::search(std::size_t moving, const WorkSharing& sharing) {
  constexpr std::size_t kPlacesAPart = 4096;
  const std::size_t parts = (moving + kPlacesAPart - 1) / kPlacesAPart;
  if (parts_.size() + 1 < parts) parts_.resize(parts - 1);
  pairs_.clear();
  std::int64_t compared = 0;
  sharing.for_each_chunk(moving, kPlacesAPart, [&](std::size_t first, std::size_t end) {
    const auto from = static_cast<std::int32_t>(first), to = static_cast<std::int32_t>(end);
    if (first == 0) {
      compared = HWY_DYNAMIC_DISPATCH(SearchCells)(cells_, from, to, pairs_);
      return;
    }
    Part& part = parts_[first / kPlacesAPart - 1];
    part.pairs.clear();
    part.compared = HWY_DYNAMIC_DISPATCH(SearchCells)(cells_, from, to, part.pairs);
  });
  for (std::size_t k = 0; k + 1 < parts; ++k) {
    pairs_.insert(pairs_.end(), parts_[k].pairs.begin(), parts_[k].pairs.end());
    compared += parts_[k].compared;
  }
  comparisons_ = static_cast<double>(compared);
}

}  // namespace stillgrid::dynamics
#endif
