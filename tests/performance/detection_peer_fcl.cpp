#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision_object.h>

#include <vector>

#include "tests/performance/detection_peers.hpp"

namespace stillgrid::performance {
namespace {

class FclTree : public DetectionPeer {
 public:
  explicit FclTree(std::span<const collision::SweptBound> balls) {
    for (std::size_t i = 0; i < balls.size(); ++i) {
      objects_.push_back(std::make_unique<fcl::CollisionObjectf>(
          std::make_shared<fcl::Spheref>(balls[i].bounding_radius_m)));
      place(i, balls[i]);
      objects_.back()->setUserData(reinterpret_cast<void*>(i));
    }
    std::vector<fcl::CollisionObjectf*> all;
    for (const auto& object : objects_) all.push_back(object.get());
    manager_.max_tree_nonbalanced_level = 2;  // else it decays from step to step
    manager_.registerObjects(all);
    manager_.setup();
  }

  std::size_t find(std::span<const collision::SweptBound> balls) override {
    for (std::size_t i = 0; i < balls.size(); ++i) place(i, balls[i]);
    manager_.update();
    Query query{balls};
    manager_.collide(&query, [](fcl::CollisionObjectf* a, fcl::CollisionObjectf* b, void* data) {
      auto& [all, found] = *static_cast<Query*>(data);
      const collision::SweptBound& p = all[reinterpret_cast<std::size_t>(a->getUserData())];
      const collision::SweptBound& q = all[reinterpret_cast<std::size_t>(b->getUserData())];
      const float x = p.centre_m[0] - q.centre_m[0], y = p.centre_m[1] - q.centre_m[1],
                  z = p.centre_m[2] - q.centre_m[2],
                  bounding_radius_m = p.bounding_radius_m + q.bounding_radius_m;
      found += x * x + y * y + z * z < bounding_radius_m * bounding_radius_m;
      return false;  // go on
    });
    return query.found;
  }

 private:
  struct Query {
    std::span<const collision::SweptBound> balls;
    std::size_t found = 0;
  };
  void place(std::size_t i, const collision::SweptBound& ball) {
    const auto& c = ball.centre_m;
    objects_[i]->setTranslation(fcl::Vector3f(c[0], c[1], c[2]));
    objects_[i]->computeAABB();
  }

  std::vector<std::unique_ptr<fcl::CollisionObjectf>> objects_;
  fcl::DynamicAABBTreeCollisionManagerf manager_;
};

}  // namespace

std::unique_ptr<DetectionPeer> fcl_tree(std::span<const collision::SweptBound> balls) {
  return std::make_unique<FclTree>(balls);
}

}  // namespace stillgrid::performance
