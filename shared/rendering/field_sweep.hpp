#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "shared/collision/distance_field.hpp"

namespace stillgrid::rendering {

/// Counts down the samples that a tick may take.
struct SampleBudget {
  std::uint32_t left;
  bool truncated = false;

  bool spend() noexcept {
    truncated = truncated || left == 0;
    left -= left == 0 ? 0 : 1;
    return !truncated;
  }
};

/// Where a sphere that went straight from one place to another met a solid: where it was pushed
/// back hardest before the field turned to push it on. Nothing where it touched at the start, or
/// never. Body frame. Looks at so many places at most, in steps of a quarter of the radius near the
/// solid: what is crossed is no shorter than the sphere's diameter. Realtime: wait-free.
[[nodiscard]] std::optional<collision::FieldContact> met_on_the_way(
    const collision::FieldView& field, const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m,
    double radius_m, SampleBudget& budget) noexcept;

}  // namespace stillgrid::rendering
