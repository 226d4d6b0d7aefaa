#include <algorithm>
#include <cmath>

#include "shared/collision/voxel_grid.hpp"

namespace stillgrid::collision {
namespace {

/// More than the test of two swept bounds (meet) can round off.
constexpr double kOutwards = 1.0 + 1e-6;

Eigen::Vector3d vector(const std::array<float, 3>& v) {
  return {v[0], v[1], v[2]};
}

/// The ball round `centre_m` that reaches radius_m beyond the farthest of `points`.
template <class... Points>
SweptBound bound_points(const Eigen::Vector3d& centre_m, double radius_m, const Points&... points) {
  // What rounding moves the centre is bounded, not measured: g++ 12 folds the way to float and back
  // away when it vectorises it.
  constexpr double kHalfUlp = 1.0 / (1U << 24U);
  const double away_m = std::sqrt(std::max({(points - centre_m).squaredNorm()...}));
  const double rounded_m = kHalfUlp * centre_m.norm();
  const Eigen::Vector3f c = centre_m.cast<float>();
  return {{c.x(), c.y(), c.z()}, static_cast<float>((away_m + radius_m + rounded_m) * kOutwards)};
}

}  // namespace

SweptBound bound_sphere(const Eigen::Vector3d& centre_m, double radius_m) noexcept {
  return bound_points(centre_m, radius_m, centre_m, centre_m);
}

SweptBound bound_sweep(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m,
                       double radius_m) noexcept {
  return bound_points(0.5 * (from_m + to_m), radius_m, from_m, to_m);
}

SweptBound bound_sweep(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m,
                       const Eigen::Vector3d& or_to_m, double radius_m) noexcept {
  const Eigen::Vector3d low_m = from_m.cwiseMin(to_m).cwiseMin(or_to_m);
  const Eigen::Vector3d high_m = from_m.cwiseMax(to_m).cwiseMax(or_to_m);
  return bound_points(0.5 * (low_m + high_m), radius_m, from_m, to_m, or_to_m);
}

SweptBound bound_history(const proto::SphereRecord& record) noexcept {
  const Eigen::Vector3d newest_m = vector(record.newest.position_m),
                        before_m = vector(record.before.position_m);
  if (newest_m.hasNaN() && before_m.hasNaN())
    return bound_sphere(Eigen::Vector3d::Zero(), record.radius_m);
  return bound_sweep(before_m.hasNaN() ? newest_m : before_m,
                     newest_m.hasNaN() ? before_m : newest_m, record.radius_m);
}

std::vector<SweptBound> history_bounds(std::span<const proto::SphereRecord> records) {
  std::vector<SweptBound> swept_bounds;
  swept_bounds.reserve(records.size());
  for (const proto::SphereRecord& record : records) swept_bounds.push_back(bound_history(record));
  return swept_bounds;
}

}  // namespace stillgrid::collision
