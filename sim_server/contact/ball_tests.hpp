#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/collision/still_grid.hpp"

namespace stillgrid {

/// Numbers of two moving spheres, a < b.
struct SpherePair {
  std::uint32_t a, b;
  [[nodiscard]] friend bool operator==(const SpherePair&, const SpherePair&) = default;
};

/// Copies to `found` the pairs whose balls overlap, dx dx + dy dy + dz dz < (ra + rb)^2 in float
/// arithmetic; in their order. Returns how many.
/// Pre: found.size() >= pairs.size().
[[nodiscard]] std::size_t overlapping_pairs(std::span<const SpherePair> pairs,
                                            std::span<const Cover> balls,
                                            std::span<SpherePair> found);

/// Writes to `leavers`, ascending, the numbers of the balls that their covers do not hold (a ball
/// that is no number is held by none). Gives up where there are more than leavers.size(), and
/// returns a larger number than that.
[[nodiscard]] std::size_t find_leavers(std::span<const Cover> balls, std::span<const Cover> covers,
                                       std::span<std::uint32_t> leavers);

/// Whether a cover holds a ball, with that slack to spare which covers have.
[[nodiscard]] bool holds(const Cover& cover, const Cover& ball) noexcept;

/// A cover's reach, as a factor on what it must hold, so that rounding in any test of ours, here or
/// in meet(), never loses a pair whose balls overlap.
inline constexpr float kCoverSlack = 4e-6F;

}  // namespace stillgrid
