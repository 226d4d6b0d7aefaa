#include "tests/performance/query_peers.hpp"

#include <BulletCollision/BroadphaseCollision/btDbvt.h>

#include <algorithm>
#include <array>
#include <nanoflann.hpp>

namespace stillgrid::performance {

struct BulletTree::Tree {
  explicit Tree(std::span<const PlainSphere> all) : spheres(all.begin(), all.end()) {}
  std::vector<PlainSphere> spheres;
  btDbvt boxes;
};

namespace {

btDbvtVolume box_round(const PlainSphere& sphere) {
  return btDbvtVolume::FromCR({sphere.x_m, sphere.y_m, sphere.z_m}, sphere.radius_m);
}

struct SumOfLeaves final : btDbvt::ICollide {
  SumOfLeaves(const std::vector<PlainSphere>& all, const PlainSphere& one)
      : spheres(all), probe(one) {}
  void Process(const btDbvtNode* leaf) override {
    sum_N += push_N(probe, spheres[static_cast<std::size_t>(leaf->dataAsInt)]);
  }
  const std::vector<PlainSphere>& spheres;
  const PlainSphere& probe;
  Eigen::Vector3f sum_N = Eigen::Vector3f::Zero();
};

}  // namespace

BulletTree::BulletTree(std::span<const PlainSphere> spheres)
    : tree_(std::make_unique<Tree>(spheres)) {
  for (std::size_t i = 0; i < spheres.size(); ++i)
    tree_->boxes.insert(box_round(spheres[i]), nullptr)->dataAsInt = static_cast<int>(i);
  tree_->boxes.optimizeTopDown();
}

BulletTree::~BulletTree() = default;

Eigen::Vector3f BulletTree::force_N(const PlainSphere& probe) const {
  SumOfLeaves sum(tree_->spheres, probe);
  tree_->boxes.collideTV(tree_->boxes.m_root, box_round(probe), sum);
  return sum.sum_N;
}

namespace {

struct Points {
  std::vector<PlainSphere> spheres;
  [[nodiscard]] std::size_t kdtree_get_point_count() const { return spheres.size(); }
  [[nodiscard]] float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    const PlainSphere& s = spheres[i];
    return axis == 0 ? s.x_m : axis == 1 ? s.y_m : s.z_m;
  }
  template <class Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;
  }
};

/// Sums instead of collecting, which would allocate.
struct SumOfPoints {
  const std::vector<PlainSphere>& spheres;
  const PlainSphere& probe;
  float search_radius_squared_m2;
  Eigen::Vector3f sum_N = Eigen::Vector3f::Zero();

  [[nodiscard]] bool full() const { return true; }
  bool addPoint(float /*squared_m2*/, std::size_t i) {  // NOLINT: nanoflann's name
    sum_N += push_N(probe, spheres[i]);
    return true;
  }
  [[nodiscard]] float worstDist() const {
    return search_radius_squared_m2;
  }  // NOLINT: nanoflann's name
};

using Index =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Points>, Points, 3>;

}  // namespace

struct NanoflannTree::Tree {
  explicit Tree(std::span<const PlainSphere> spheres)
      : points{{spheres.begin(), spheres.end()}}, index(3, points) {
    for (const PlainSphere& sphere : spheres) largest_m = std::max(largest_m, sphere.radius_m);
  }
  float largest_m = 0.0F;
  Points points;
  Index index;
};

NanoflannTree::NanoflannTree(std::span<const PlainSphere> spheres)
    : tree_(std::make_unique<Tree>(spheres)) {}

NanoflannTree::~NanoflannTree() = default;

Eigen::Vector3f NanoflannTree::force_N(const PlainSphere& probe) const {
  const float bounding_radius_m = probe.radius_m + tree_->largest_m;
  SumOfPoints sum{tree_->points.spheres, probe, bounding_radius_m * bounding_radius_m};
  const std::array<float, 3> centre_m{probe.x_m, probe.y_m, probe.z_m};
  tree_->index.findNeighbors(sum, centre_m.data(), nanoflann::SearchParams());
  return sum.sum_N;
}

}  // namespace stillgrid::performance
