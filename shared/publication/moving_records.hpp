#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/stillgrid.h"
#include "shared/collision/voxel_grid.hpp"

namespace stillgrid::publication {

/// The moving spheres of a publisher as snapshots have them: declared, then placed once a step, in
/// a grid that holds their history. Nothing is allocated after construction. Thread: one.
class MovingRecords {
 public:
  explicit MovingRecords(std::size_t capacity);

  /// Pre: check_shapes(), count within the capacity.
  void declare(const stillgrid_shapes& shapes) noexcept;

  /// The next state of all, period_s after the last, in the grid: moving on at their velocity, or
  /// without velocities_m_s at what they did since the last. Swept bounds have room for some steps;
  /// only when many have left theirs are all entered anew. was_shown: the last state was published;
  /// else it is forgotten. Pre: numbers.
  void place(const double* positions_m, const double* velocities_m_s, double period_s,
             bool was_shown = true);

  [[nodiscard]] std::span<proto::SphereRecord> records() noexcept {
    return grid_.records().first(count_);
  }
  [[nodiscard]] const collision::VoxelGrid& grid() const noexcept { return grid_; }
  [[nodiscard]] std::size_t count() const noexcept { return count_; }

 private:
  void push(std::size_t i, const double* position_m, const double* velocity_m_s, float rate_per_s,
            bool was_shown) noexcept;
  [[nodiscard]] bool is_held(std::size_t i) noexcept;
  [[nodiscard]] bool widen(std::size_t i) noexcept;
  void enter(double period_s);

  collision::VoxelGrid grid_;
  std::vector<collision::SweptBound> bounds_;  // as they stand in the grid
  float needed_m_ = 0.0F;                      // by what is_held() last found not to be
  std::vector<std::uint8_t> came_;             // since they were placed last
  std::size_t count_ = 0, entered_ = 0;
  bool is_first_ = true;
};

}  // namespace stillgrid::publication
