#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "proto/scene_segment.hpp"

namespace stillgrid::collision {

/// Cells that a level may take for each of its spheres, and at least.
inline constexpr std::size_t kCellsPerSphere = 8, kLeastCells = 64;

/// A level below this many spheres joins the coarser one: looking into it would cost more.
inline constexpr std::size_t kFewSpheres = 16;

/// Voxels of a level along an axis, and its cells in all.
[[nodiscard]] std::uint64_t extent_voxels(const proto::GridLevel& level, std::size_t axis) noexcept;
[[nodiscard]] std::uint64_t cell_count(const proto::GridLevel& level) noexcept;

/// A cell for each voxel of a level's extent, or, along the longest axes, a power of two that
/// repeats, where so many spheres pay for no more.
[[nodiscard]] std::array<std::uint32_t, 3> cells_for(const proto::GridLevel& level,
                                                     std::size_t spheres);

/// Whether every cell that a level read from shared memory leads to is among cell_capacity.
/// Realtime: yes.
[[nodiscard]] bool is_consistent_level(const proto::GridLevel& level,
                                       std::size_t cell_capacity) noexcept;

/// The class of a radius, counted from the longest: some octaves each, more where eight classes do
/// not do.
class Octaves {
 public:
  Octaves(float longest_m, float shortest_m, std::uint32_t octaves)
      : longest_m_(longest_m), octaves_(octaves), most_(octaves_below(shortest_m)) {}
  [[nodiscard]] std::uint32_t most() const { return std::min(most_, proto::kMaxLevels - 1); }
  [[nodiscard]] std::uint8_t of(float bounding_radius_m) const {
    const std::uint32_t octaves = octaves_below(bounding_radius_m);
    return static_cast<std::uint8_t>(
        most_ < proto::kMaxLevels ? octaves : octaves * (proto::kMaxLevels - 1) / most_);
  }

 private:
  /// The whole part of log2(longest / radius), which is the exponent of the quotient, in classes.
  [[nodiscard]] std::uint32_t octaves_below(float bounding_radius_m) const {
    constexpr std::uint32_t kMantissaBits = 23, kBias = 127;
    const float quotient =
        std::min(longest_m_ / bounding_radius_m, std::numeric_limits<float>::max());
    return ((std::bit_cast<std::uint32_t>(quotient) >> kMantissaBits) - kBias) / octaves_;
  }

  float longest_m_;
  std::uint32_t octaves_;
  std::uint32_t most_;
};

}  // namespace stillgrid::collision
