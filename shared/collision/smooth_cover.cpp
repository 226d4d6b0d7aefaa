#include "shared/collision/smooth_cover.hpp"

#include <Eigen/LU>
#include <algorithm>

namespace stillgrid::collision {

using Eigen::Vector3d;

double SmoothCover::neighbour_gap_m(double proxy_radius_m, double radius_m) noexcept {
  return std::min(radius_m * radius_m / (proxy_radius_m + radius_m), margin_m(proxy_radius_m));
}

void SmoothCover::find_near(double proxy_radius_m, std::span<const SeenSurface> surfaces,
                            std::span<const HalfSpace> spaces) noexcept {
  count_ = 0;
  double left_out = 0.0;
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    if (surfaces[k].body < 0) continue;
    const Near near{k,
                    1.0 - spaces[k].gap_m / neighbour_gap_m(proxy_radius_m, surfaces[k].radius_m),
                    spaces[k].normal};
    if (!(near.closeness > 0.0)) continue;
    if (count_ < kMaxNear) {
      near_[count_++] = near;
      continue;
    }
    Near& farthest = *std::ranges::min_element(near_, {}, &Near::closeness);
    left_out = std::max(left_out, std::min(farthest.closeness, near.closeness));
    if (farthest.closeness < near.closeness) farthest = near;
  }
  // Who leaves the nearest, or comes, has no weight then. All may be as near as who is left out.
  constexpr double kLeast = 1e-6;
  for (std::size_t i = 0; i < count_; ++i)
    near_[i].closeness = std::max(near_[i].closeness - left_out, kLeast);
}

void SmoothCover::lay(double proxy_radius_m, std::span<const SeenSurface> surfaces,
                      std::span<HalfSpace> spaces) noexcept {
  constexpr double kRidge = 0.1;  // of the radius: variance that a plane's direction must exceed
  find_near(proxy_radius_m, surfaces, spaces);
  for (std::size_t i = 0; i < count_; ++i) {
    double sum = 0.0, radius_m = 0.0;
    Vector3d mean_m = Vector3d::Zero(), normal = Vector3d::Zero();
    for (std::size_t j = 0; j < count_; ++j) {
      const SeenSurface& sphere = surfaces[near_[j].index];
      const bool is_same = sphere.body == surfaces[near_[i].index].body;
      // A surface that turns by more than 60 degrees is another face.
      const double cosine = i == j ? 1.0 : near_[i].normal.dot(near_[j].normal);
      const double facing = is_same ? 2.0 * cosine - 1.0 : 0.0;
      const double weight = near_[j].closeness * near_[j].closeness * std::max(0.0, facing);
      weights_[i][j] = weight;
      sum += weight;
      radius_m += weight * sphere.radius_m;
      mean_m -= weight * sphere.line_m;
      normal += weight * near_[j].normal;
    }
    radius_m /= sum;
    mean_m /= sum;
    // Of the spheres' tops, for a large one lies deeper than a small one beside it.
    const Vector3d upwards = normal.normalized();
    Eigen::Matrix3d spread_m2 = Eigen::Matrix3d::Zero();
    for (std::size_t j = 0; j < count_; ++j) {
      weights_[i][j] /= sum;
      const SeenSurface& sphere = surfaces[near_[j].index];
      const Vector3d top_m = (sphere.radius_m - radius_m) * upwards - sphere.line_m - mean_m;
      spread_m2 += weights_[i][j] * top_m * top_m.transpose();
    }
    spread_m2.diagonal().array() += kRidge * kRidge * radius_m * radius_m;
    HalfSpace& space = spaces[near_[i].index];
    space.normal = (spread_m2.inverse() * normal).normalized();
    space.gap_m = -mean_m.dot(space.normal) - proxy_radius_m - radius_m;
  }
}

void SmoothCover::share(std::span<HalfSpace> spaces) const noexcept {
  struct Sum {
    Vector3d push_m = Vector3d::Zero();
    double energy_m2 = 0.0;
  };
  std::array<Sum, kMaxNear> sums;
  for (std::size_t i = 0; i < count_; ++i) {
    const HalfSpace& plane = spaces[near_[i].index];
    if (!(plane.push_m > 0.0)) continue;
    for (std::size_t j = 0; j < count_; ++j) {
      sums[j].push_m += weights_[i][j] * plane.push_m * plane.normal;
      sums[j].energy_m2 += weights_[i][j] * plane.push_m * plane.depth_m;
    }
  }
  for (std::size_t j = 0; j < count_; ++j) {
    HalfSpace& space = spaces[near_[j].index];
    space.push_m = sums[j].push_m.norm();
    if (!(space.push_m > 0.0)) continue;
    space.normal = sums[j].push_m / space.push_m;
    space.depth_m = std::max(space.push_m, sums[j].energy_m2 / space.push_m);
  }
}

}  // namespace stillgrid::collision
