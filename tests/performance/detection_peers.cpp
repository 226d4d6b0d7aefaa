#include "tests/performance/detection_peers.hpp"

#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <BulletCollision/BroadphaseCollision/btDbvt.h>

#include <vector>

namespace stillgrid::performance {
namespace {

/// The number of a ball in the pointer that Bullet keeps for its user.
void* pointer_of(std::size_t i) {
  return reinterpret_cast<void*>(i);
}
std::size_t number_of(const void* pointer) {
  return reinterpret_cast<std::size_t>(pointer);
}

bool overlap(const collision::SweptBound& a, const collision::SweptBound& b) {
  const float x = a.centre_m[0] - b.centre_m[0], y = a.centre_m[1] - b.centre_m[1],
              z = a.centre_m[2] - b.centre_m[2],
              bounding_radius_m = a.bounding_radius_m + b.bounding_radius_m;
  return x * x + y * y + z * z < bounding_radius_m * bounding_radius_m;
}

btVector3 centre(const collision::SweptBound& ball) {
  return {ball.centre_m[0], ball.centre_m[1], ball.centre_m[2]};
}
btVector3 half_box(const collision::SweptBound& ball) {
  return {ball.bounding_radius_m, ball.bounding_radius_m, ball.bounding_radius_m};
}

class AxisSweep : public DetectionPeer {
 public:
  AxisSweep(std::span<const collision::SweptBound> balls, float half_edge_m)
      : sweep_(btVector3(-half_edge_m, -half_edge_m, -half_edge_m),
               btVector3(half_edge_m, half_edge_m, half_edge_m),
               static_cast<unsigned>(balls.size()) + 2, nullptr, true) {
    for (std::size_t i = 0; i < balls.size(); ++i)
      proxies_.push_back(sweep_.createProxy(centre(balls[i]) - half_box(balls[i]),
                                            centre(balls[i]) + half_box(balls[i]), 0, pointer_of(i),
                                            1, 1, nullptr));
  }
  ~AxisSweep() override {
    for (btBroadphaseProxy* proxy : proxies_) sweep_.destroyProxy(proxy, nullptr);
  }
  AxisSweep(const AxisSweep&) = delete;
  AxisSweep& operator=(const AxisSweep&) = delete;
  AxisSweep(AxisSweep&&) = delete;
  AxisSweep& operator=(AxisSweep&&) = delete;

  std::size_t find(std::span<const collision::SweptBound> balls) override {
    for (std::size_t i = 0; i < balls.size(); ++i)
      sweep_.setAabb(proxies_[i], centre(balls[i]) - half_box(balls[i]),
                     centre(balls[i]) + half_box(balls[i]), nullptr);
    sweep_.calculateOverlappingPairs(nullptr);
    const btBroadphasePairArray& pairs =
        sweep_.getOverlappingPairCache()->getOverlappingPairArray();
    std::size_t found = 0;
    for (int i = 0; i < pairs.size(); ++i)
      found += overlap(balls[number_of(pairs[i].m_pProxy0->m_clientObject)],
                       balls[number_of(pairs[i].m_pProxy1->m_clientObject)]);
    return found;
  }

 private:
  bt32BitAxisSweep3 sweep_;
  std::vector<btBroadphaseProxy*> proxies_;
};

class Tree : public DetectionPeer {
 public:
  Tree(std::span<const collision::SweptBound> balls, float margin_m) : margin_m_(margin_m) {
    for (std::size_t i = 0; i < balls.size(); ++i) {
      btDbvtVolume box = btDbvtVolume::FromCE(centre(balls[i]), half_box(balls[i]));
      leaves_.push_back(tree_.insert(box, pointer_of(i)));
    }
    tree_.optimizeTopDown();
  }

  std::size_t find(std::span<const collision::SweptBound> balls) override {
    for (std::size_t i = 0; i < balls.size(); ++i) {
      btDbvtVolume box = btDbvtVolume::FromCE(centre(balls[i]), half_box(balls[i]));
      tree_.update(leaves_[i], box, margin_m_);
    }
    tree_.optimizeIncremental(1 + static_cast<int>(balls.size()) / 100);
    Count count(balls);
    tree_.collideTTpersistentStack(tree_.m_root, tree_.m_root, count);
    return count.found;
  }

 private:
  struct Count : btDbvt::ICollide {
    explicit Count(std::span<const collision::SweptBound> all) : balls(all) {}
    void Process(const btDbvtNode* a, const btDbvtNode* b) override {
      found += a != b && overlap(balls[number_of(a->data)], balls[number_of(b->data)]);
    }
    std::span<const collision::SweptBound> balls;
    std::size_t found = 0;
  };

  btDbvt tree_;
  std::vector<btDbvtNode*> leaves_;
  float margin_m_;
};

}  // namespace

std::unique_ptr<DetectionPeer> bullet_axis_sweep(std::span<const collision::SweptBound> balls,
                                                 float half_edge_m) {
  return std::make_unique<AxisSweep>(balls, half_edge_m);
}

std::unique_ptr<DetectionPeer> bullet_tree(std::span<const collision::SweptBound> balls,
                                           float margin_m) {
  return std::make_unique<Tree>(balls, margin_m);
}

}  // namespace stillgrid::performance
