#pragma once

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <span>
#include <vector>

namespace stillgrid::performance {

/// A static sphere as the peers keep it: 16 bytes.
struct PlainSphere {
  float x_m, y_m, z_m, radius_m;
};

/// A spring on the depth, along the line of the centres: what every method sums here.
[[nodiscard]] inline Eigen::Vector3f push_N(const PlainSphere& probe, const PlainSphere& sphere) {
  constexpr float kStiffness_N_per_m = 500.0F;
  const Eigen::Vector3f apart_m(probe.x_m - sphere.x_m, probe.y_m - sphere.y_m,
                                probe.z_m - sphere.z_m);
  const float bounding_radius_m = probe.radius_m + sphere.radius_m,
              squared_m2 = apart_m.squaredNorm();
  if (!(squared_m2 < bounding_radius_m * bounding_radius_m) || squared_m2 == 0.0F)
    return Eigen::Vector3f::Zero();
  const float distance_m = std::sqrt(squared_m2);
  return kStiffness_N_per_m * (bounding_radius_m - distance_m) / distance_m * apart_m;
}

/// Bullet's dynamic tree of boxes, built anew from the top, which is its best.
class BulletTree {
 public:
  explicit BulletTree(std::span<const PlainSphere> spheres);
  ~BulletTree();
  BulletTree(const BulletTree&) = delete;
  BulletTree& operator=(const BulletTree&) = delete;
  BulletTree(BulletTree&&) = delete;
  BulletTree& operator=(BulletTree&&) = delete;

  [[nodiscard]] Eigen::Vector3f force_N(const PlainSphere& probe) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

/// nanoflann's tree of points, searched as far as the probe and the largest sphere reach.
class NanoflannTree {
 public:
  explicit NanoflannTree(std::span<const PlainSphere> spheres);
  ~NanoflannTree();
  NanoflannTree(const NanoflannTree&) = delete;
  NanoflannTree& operator=(const NanoflannTree&) = delete;
  NanoflannTree(NanoflannTree&&) = delete;
  NanoflannTree& operator=(NanoflannTree&&) = delete;

  [[nodiscard]] Eigen::Vector3f force_N(const PlainSphere& probe) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace stillgrid::performance
