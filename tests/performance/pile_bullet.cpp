#include <btBulletDynamicsCommon.h>

#include <map>

#include "tests/performance/pile.hpp"

namespace stillgrid::performance {
namespace {

constexpr btScalar kRest_s = 0.5;  // until Bullet deactivates, as ours
/// Its margins are absolute and made for bodies of about one: here of centimetres.
constexpr double kUnits_per_m = 100.0;

btScalar length_of(double length_m) {
  return static_cast<btScalar>(kUnits_per_m * length_m);
}
btVector3 vector_of(const Eigen::Vector3d& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

class BulletPile : public PileEngine {
 public:
  BulletPile(const Pile& pile, bool may_sleep)
      : dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &solver_, &configuration_) {
    world_.setGravity(btVector3(0, 0, -length_of(kPileGravity_m_s2)));
    gDeactivationTime = kRest_s;
    const auto friction = static_cast<btScalar>(pile.friction);
    add_plane({0, 0, 1}, 0.0, friction);
    for (int axis = 0; axis < 2 && !pile.bin_m.isZero(); ++axis) {
      add_plane(Eigen::Vector3d::Unit(axis), 0.0, friction);
      add_plane(-Eigen::Vector3d::Unit(axis), -pile.bin_m[axis], friction);
    }
    first_sphere_ = bodies_.size();
    for (const PileSphere& sphere : pile.spheres) {
      add(std::make_unique<btSphereShape>(length_of(sphere.radius_m)),
          static_cast<btScalar>(sphere.mass_kg), vector_of(kUnits_per_m * sphere.position_m),
          friction);
      if (!may_sleep) bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    }
  }
  ~BulletPile() override {
    for (const auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  BulletPile(const BulletPile&) = delete;
  BulletPile& operator=(const BulletPile&) = delete;
  BulletPile(BulletPile&&) = delete;
  BulletPile& operator=(BulletPile&&) = delete;

  void step() override { world_.stepSimulation(static_cast<btScalar>(kPileStep_s), 0); }
  [[nodiscard]] int touching() const override {
    int count = 0;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i)
      count += dispatcher_.getManifoldByIndexInternal(i)->getNumContacts() > 0 ? 1 : 0;
    return count;
  }
  [[nodiscard]] int sleeping() const override {
    int count = 0;
    for (std::size_t i = first_sphere_; i < bodies_.size(); ++i)
      count += bodies_[i]->isActive() ? 0 : 1;
    return count;
  }
  [[nodiscard]] double mean_height_m() const override {
    double sum_m = 0.0;
    for (std::size_t i = first_sphere_; i < bodies_.size(); ++i)
      sum_m += bodies_[i]->getWorldTransform().getOrigin().z();
    return sum_m / kUnits_per_m / static_cast<double>(bodies_.size() - first_sphere_);
  }

 private:
  void add_plane(const Eigen::Vector3d& normal, double offset_m, btScalar friction) {
    add(std::make_unique<btStaticPlaneShape>(vector_of(normal), length_of(offset_m)), 0,
        btVector3(0, 0, 0), friction);
  }
  void add(std::unique_ptr<btCollisionShape> shape, btScalar mass_kg, const btVector3& at_m,
           btScalar friction) {
    btVector3 inertia(0, 0, 0);
    if (mass_kg > 0) shape->calculateLocalInertia(mass_kg, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(mass_kg, nullptr, shape.get(), inertia);
    info.m_startWorldTransform.setOrigin(at_m);
    info.m_friction = friction;
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    shapes_.push_back(std::move(shape));
    world_.addRigidBody(bodies_.back().get());
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::size_t first_sphere_ = 0;
};

}  // namespace

std::unique_ptr<PileEngine> bullet_pile(const Pile& pile, bool may_sleep) {
  return std::make_unique<BulletPile>(pile, may_sleep);
}

}  // namespace stillgrid::performance
