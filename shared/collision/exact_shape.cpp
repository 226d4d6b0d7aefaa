#include "shared/collision/exact_shape.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "proto/segment_header.hpp"

namespace stillgrid::collision {
namespace {

using Eigen::Vector3d;
using proto::FieldKind;

constexpr float kRounding = 1e-6F;  // of a radius

/// A distance and its gradient.
struct Near {
  double distance_m = 0.0;
  Vector3d gradient = Vector3d::UnitZ();
};

/// Of a product of intervals: `beyond` is how far a coordinate exceeds each of them, negative
/// within; `out` are their outward unit vectors, the columns.
template <int Sides>
Near near_sides(const Eigen::Array<double, Sides, 1>& beyond,
                const Eigen::Matrix<double, 3, Sides>& out) {
  Eigen::Index nearest = 0;
  const double most_m = beyond.maxCoeff(&nearest);
  if (most_m <= 0.0) return {most_m, out.col(nearest)};
  const Eigen::Matrix<double, Sides, 1> outside_m = beyond.max(0.0).matrix();
  const double distance_m = outside_m.norm();
  return {distance_m, out * (outside_m / distance_m)};
}

Near near_box(const Vector3d& half_m, const Vector3d& point_m) {
  Eigen::Matrix3d out = Eigen::Matrix3d::Zero();
  for (int k = 0; k < 3; ++k) out(k, k) = std::copysign(1.0, point_m[k]);
  return near_sides<3>(point_m.array().abs() - half_m.array(), out);
}

/// Of any point of the axis some direction away from it counts.
Vector3d away_from_axis(const Vector3d& point_m) {
  const Vector3d away(point_m.x(), point_m.y(), 0.0);
  const double length = away.norm();
  return length > 0.0 ? Vector3d(away / length) : Vector3d(Vector3d::UnitX());
}

Near near_cylinder(const Vector3d& half_m, const Vector3d& point_m) {
  Eigen::Matrix<double, 3, 2> out;
  out << away_from_axis(point_m), std::copysign(1.0, point_m.z()) * Vector3d::UnitZ();
  return near_sides<2>(
      {std::hypot(point_m.x(), point_m.y()) - half_m.x(), std::abs(point_m.z()) - half_m.z()}, out);
}

Near near_capsule(const Vector3d& half_m, const Vector3d& point_m) {
  const double straight_m = half_m.z() - half_m.x();
  Vector3d away = point_m;
  away.z() -= std::clamp(point_m.z(), -straight_m, straight_m);
  const double length = away.norm();
  return {length - half_m.x(),
          length > 0.0 ? Vector3d(away / length) : Vector3d(Vector3d::UnitX())};
}

}  // namespace

double ball_radius_m(FieldKind kind, const Vector3d& half_m) noexcept {
  if (kind == FieldKind::kBox) return half_m.norm();
  return kind == FieldKind::kCylinder ? std::hypot(half_m.x(), half_m.z()) : half_m.z();
}

proto::FieldShape exact_shape(FieldKind kind, const Vector3d& half_m) noexcept {
  proto::FieldShape shape{};
  shape.kind = static_cast<std::uint32_t>(kind);
  Eigen::Map<Eigen::Vector3f>(shape.lowest_m.data()) = -half_m.cast<float>();
  // Above what rounding may have taken.
  shape.bounding_radius_m = static_cast<float>((1.0 + 3.0 * double{kRounding}) *
                                               ball_radius_m(kind, half_sides_m(shape)));
  return shape;
}

bool is_consistent_exact(const proto::FieldShape& shape) noexcept {
  if (shape.kind >= proto::kFieldKinds) return false;
  const auto& [x, y, z] = shape.lowest_m;
  // Written so that a NaN does not pass.
  for (const float lowest_m : shape.lowest_m)
    if (!(-lowest_m > 0.0F && -lowest_m <= proto::kLargestNumber)) return false;
  const auto kind = static_cast<FieldKind>(shape.kind);
  const bool is_round = kind != FieldKind::kBox, is_capsule = kind == FieldKind::kCapsule;
  if ((is_round && x != y) || (is_capsule && z > x)) return false;
  proto::FieldShape only = exact_shape(kind, half_sides_m(shape));
  // Another compiler may round the radius otherwise.
  if (!(std::abs(shape.bounding_radius_m - only.bounding_radius_m) <=
        kRounding * only.bounding_radius_m))
    return false;
  only.bounding_radius_m = shape.bounding_radius_m;
  return std::memcmp(&only, &shape, sizeof only) == 0;
}

std::optional<FieldSample> exact_sample(const proto::FieldShape& shape,
                                        const Vector3d& point_m) noexcept {
  if (!point_m.allFinite()) return std::nullopt;
  const Vector3d half_m = half_sides_m(shape);
  const auto kind = static_cast<FieldKind>(shape.kind);
  const Near near = kind == FieldKind::kBox        ? near_box(half_m, point_m)
                    : kind == FieldKind::kCylinder ? near_cylinder(half_m, point_m)
                                                   : near_capsule(half_m, point_m);
  return FieldSample{.distance_m = near.distance_m, .gradient = near.gradient};
}

}  // namespace stillgrid::collision
