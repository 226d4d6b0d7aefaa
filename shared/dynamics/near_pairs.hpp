#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/dynamics/scene_state.hpp"
#include "shared/dynamics/work_sharing.hpp"

namespace stillgrid::dynamics {

/// A numbered pair, first < second.
struct NearPair {
  std::int32_t first, second;
};

/// Finds all pairs of balls that overlap, by a grid of cells that are as wide as the largest ball.
/// Balls far outside the bulk are counted to its outermost cells, so that memory is bounded.
///
/// Thread: one. Memory is kept from call to call, and grows only with the number of balls or pairs.
class NearPairs {
 public:
  /// balls: centres in m and, as w, radii. still: how many of the last ones never move. Pairs of
  /// two of these are not searched. Realtime: no.
  void find(std::span<const Vector4> balls, std::size_t still = 0,
            const WorkSharing& sharing = WorkSharing::alone());

  /// Appends the places in order() of balls of the last find() whose cells are near a ball. They
  /// include all that overlap it, and ascend. w: its radius.
  void append_near(const Vector4& ball, std::vector<std::int32_t>& places) const;

  /// The numbers of the balls in the order of cells, those that never move last, of the last
  /// find().
  [[nodiscard]] std::span<const std::int32_t> order() const noexcept { return order_; }
  /// Sorts balls without finding pairs, for each_near().
  void arrange(std::span<const Vector4> balls);
  /// Calls visit(index) for all balls of the last find() or arrange() that may overlap a ball, and
  /// for some that do not. Realtime: yes.
  template <class Visit>
  void each_near(const Vector4& ball, const Visit& visit) const;
  /// Forgets the pairs of the last find().
  void forget() noexcept {
    pairs_.clear();
    comparisons_ = 0.0;
  }
  /// Returns how many pairs of balls the last find() compared.
  [[nodiscard]] double comparisons() const noexcept { return comparisons_; }
  /// Pairs of places in order(), ascending in `first`.
  [[nodiscard]] std::span<const NearPair> pairs() const noexcept { return pairs_; }

  /// Input of the search. Arrays are padded by the lanes of the widest vector.
  struct Cells {
    std::array<int, 3> count{};
    /// The first place of each cell, again for balls that never move where there are any, and the
    /// end.
    std::vector<std::int32_t> start;
    std::vector<std::int32_t> cell;      // places
    std::vector<float> x, y, z, radius;  // places, relative to the grid's corner
  };

 private:
  void choose_grid(std::span<const Vector4> balls);
  void search(std::size_t moving, const WorkSharing& sharing);
  void sort_into_cells(std::span<const Vector4> balls, std::size_t still);
  [[nodiscard]] int cell_along(double coordinate_m, std::size_t axis) const;
  template <class Visit>
  void each_place(const Vector4& ball, double distance_m, const Visit& visit) const;

  Cells cells_;
  std::array<double, 3> corner_m_{};
  double width_m_ = 1.0, largest_m_ = 0.0, comparisons_ = 0.0;
  std::vector<std::int32_t> order_, next_;
  std::vector<NearPair> pairs_;
  /// Pairs whose first is in a part of the places, and how many were compared there.
  struct Part {
    std::vector<NearPair> pairs;
    std::int64_t compared = 0;
  };
  std::vector<Part> parts_;  // all but the first, which is pairs_
};

/// Calls visit(place), in ascending order, for balls in cells up to a distance from a ball's
/// centre.
template <class Visit>
void NearPairs::each_place(const Vector4& ball, double distance_m, const Visit& visit) const {
  if (order_.empty()) return;
  const std::array<double, 3> centre_m{ball.x, ball.y, ball.z};
  std::array<int, 3> first{}, last{};
  for (std::size_t k = 0; k < 3; ++k) {
    first[k] = cell_along(centre_m[k] - distance_m, k);
    last[k] = cell_along(centre_m[k] + distance_m, k);
  }
  const auto& count = cells_.count;
  const auto cells = static_cast<std::size_t>(count[0] * count[1] * count[2]);
  for (std::size_t set = 0; set + 1 < cells_.start.size(); set += cells)
    for (int i = first[0]; i <= last[0]; ++i)
      for (int j = first[1]; j <= last[1]; ++j) {
        const auto row = set + static_cast<std::size_t>((i * count[1] + j) * count[2]);
        const auto from = cells_.start[row + static_cast<std::size_t>(first[2])];
        const auto end = cells_.start[row + static_cast<std::size_t>(last[2]) + 1];
        for (std::int32_t place = from; place < end; ++place) visit(place);
      }
}

template <class Visit>
void NearPairs::each_near(const Vector4& ball, const Visit& visit) const {
  const double distance_m = ball.w + 0.5 * width_m_;  // no ball is wider than a cell
  each_place(ball, distance_m,
             [&](std::int32_t place) { visit(order_[static_cast<std::size_t>(place)]); });
}

}  // namespace stillgrid::dynamics
