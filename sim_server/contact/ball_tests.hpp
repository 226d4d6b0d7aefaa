#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/collision/voxel_grid.hpp"

namespace stillgrid::contact {

/// Numbers of two moving spheres, a < b.
struct SpherePair {
  std::uint32_t a, b;
  [[nodiscard]] friend bool operator==(const SpherePair&, const SpherePair&) = default;
};

/// Copies to `found` the pairs whose balls overlap, dx dx + dy dy + dz dz < (ra + rb)^2 in float
/// arithmetic; in their order. Returns how many.
/// Pre: found.size() >= pairs.size().
[[nodiscard]] std::size_t overlapping_pairs(std::span<const SpherePair> pairs,
                                            std::span<const collision::SweptBound> balls,
                                            std::span<SpherePair> found);

/// Writes to `escaped`, ascending, the numbers of the balls that their swept bounds do not hold (a
/// ball that is no number is held by none). Gives up where there are more than escaped.size(), and
/// returns a larger number than that.
[[nodiscard]] std::size_t find_escaped(std::span<const collision::SweptBound> balls,
                                       std::span<const collision::SweptBound> swept_bounds,
                                       std::span<std::uint32_t> escaped);

/// Whether a swept bound holds a ball, with that slack to spare which swept bounds have.
[[nodiscard]] bool holds(const collision::SweptBound& swept_bound,
                         const collision::SweptBound& ball) noexcept;

/// A swept bound's radius, as a factor on what it must hold, so that rounding in any test of ours,
/// here or in meet(), never loses a pair whose balls overlap.
inline constexpr float kBoundSlack = 4e-6F;

}  // namespace stillgrid::contact
