#pragma once

#include <Eigen/Core>
#include <optional>

#include "proto/distance_field.hpp"
#include "shared/collision/distance_field.hpp"

namespace stillgrid::collision {

/// Whether the distance is a closed form, or of a kind that does not exist.
[[nodiscard]] inline bool is_exact(const proto::FieldShape& shape) noexcept {
  return shape.kind != static_cast<std::uint32_t>(proto::FieldKind::kSampled);
}

/// Returns half of the sides of the box around a closed form, in m. Pre: is_exact(shape).
[[nodiscard]] inline Eigen::Vector3d half_sides_m(const proto::FieldShape& shape) noexcept {
  return -Eigen::Map<const Eigen::Vector3f>(shape.lowest_m.data()).cast<double>();
}

/// Returns the radius of the ball around a closed form, m. half_m: half of its sides.
[[nodiscard]] double ball_radius_m(proto::FieldKind kind, const Eigen::Vector3d& half_m) noexcept;

/// Returns the shape of a closed form. half_m: half of its sides, rounded to floats. The result is
/// not consistent where a side is not positive, above proto::kLargestNumber, or not of that kind.
[[nodiscard]] proto::FieldShape exact_shape(proto::FieldKind kind,
                                            const Eigen::Vector3d& half_m) noexcept;

/// Whether every byte is that of exact_shape() for sides that are possible. Pre: is_exact(shape).
/// Realtime: yes.
[[nodiscard]] bool is_consistent_exact(const proto::FieldShape& shape) noexcept;

/// Returns the exact distance and its gradient, a unit vector: outside from the nearest point of
/// the surface, inside towards it. If several points are equally near, one of them counts.
/// Empty if the point is not finite. Pre: is_consistent_exact(shape). Realtime: yes.
[[nodiscard]] std::optional<FieldSample> exact_sample(const proto::FieldShape& shape,
                                                      const Eigen::Vector3d& point_m) noexcept;

}  // namespace stillgrid::collision
