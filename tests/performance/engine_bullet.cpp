#include <btBulletDynamicsCommon.h>

#include <algorithm>

#include "tests/performance/engine_peers.hpp"

namespace stillgrid::performance {
namespace {

static_assert(sizeof(btScalar) == sizeof(float));

/// Bullet's units in a metre. Its constants, as the 0.05 by which it enlarges bounds, are for
/// bodies of about one unit: with a unit of a metre, balls of 10 mm are all near each other.
constexpr double kUnits_per_m = 50.0;

btVector3 vector_of(const Eigen::Vector3d& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}
btTransform transform_of(const Pose& pose) {
  const Eigen::Quaternionf q = pose.orientation.cast<float>();
  return btTransform({q.x(), q.y(), q.z(), q.w()}, vector_of(kUnits_per_m * pose.position_m));
}

class BulletWorld : public PeerWorld {
 public:
  BulletWorld(const PeerScene& scene, BulletMethod method)
      : substeps_(method.substeps),
        dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &solver_, &configuration_) {
    world_.setGravity(vector_of(kUnits_per_m * scene.ours.description.gravity_m_s2));
    world_.getSolverInfo().m_numIterations = method.iterations;
    for (const auto& plane : scene.ours.description.planes)
      add_body(0.0, btVector3(0, 0, 0), btTransform::getIdentity(),
               std::make_unique<btStaticPlaneShape>(
                   vector_of(plane.normal), static_cast<btScalar>(kUnits_per_m * plane.offset_m)));
    planes_ = bodies_.size();
    const auto& state = scene.ours.state;
    for (std::size_t i = 0; i < state.orientation.size(); ++i) {
      const auto& rigid = scene.ours.description.rigid_bodies[i];
      add_body(
          static_cast<btScalar>(rigid.mass_kg),
          vector_of(kUnits_per_m * kUnits_per_m * rigid.inertia_kg_m2),
          transform_of({state.rigid_position_m[i].vector(), state.orientation[i].quaternion()}),
          shape_of(scene, i));
    }
    for (const auto& joint : scene.ours.description.joints) add_joint(joint);
  }
  ~BulletWorld() override {
    for (const auto& joint : joints_) world_.removeConstraint(joint.get());
    for (const auto& body : bodies_) world_.removeRigidBody(body.get());
  }

  void step() override {
    for (int i = 0; i < substeps_; ++i)
      world_.stepSimulation(0.01F / static_cast<btScalar>(substeps_), 0);
  }
  [[nodiscard]] std::vector<Pose> poses() const override {
    std::vector<Pose> poses;
    for (std::size_t i = planes_; i < bodies_.size(); ++i) {
      const btVector3& x = bodies_[i]->getCenterOfMassPosition();
      const btQuaternion q = bodies_[i]->getOrientation();
      poses.push_back(
          {Eigen::Vector3d(x.x(), x.y(), x.z()) / kUnits_per_m, {q.w(), q.x(), q.y(), q.z()}});
    }
    return poses;
  }
  /// Returns the deepest contact of each pair of moving bodies that overlap, in m.
  [[nodiscard]] std::vector<double> depths_m() {
    world_.performDiscreteCollisionDetection();
    std::vector<double> depths_m;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      const btPersistentManifold& pair = *dispatcher_.getManifoldByIndexInternal(i);
      if (pair.getBody0()->isStaticObject() || pair.getBody1()->isStaticObject()) continue;
      double depth = 0.0;
      for (int j = 0; j < pair.getNumContacts(); ++j)
        depth = std::max<double>(depth, -pair.getContactPoint(j).getDistance());
      if (depth > 0.0) depths_m.push_back(depth / kUnits_per_m);
    }
    return depths_m;
  }

 private:
  static std::unique_ptr<btCollisionShape> shape_of(const PeerScene& scene, std::size_t rigid) {
    if (!scene.box_m.empty())
      return std::make_unique<btBoxShape>(vector_of(0.5 * kUnits_per_m * scene.box_m[rigid]));
    const auto& spheres = scene.ours.description.spheres;
    if (spheres.empty()) return std::make_unique<btEmptyShape>();
    return std::make_unique<btSphereShape>(
        static_cast<btScalar>(kUnits_per_m * spheres[rigid].radius_m));
  }
  void add_body(btScalar mass_kg, const btVector3& inertia_kg_m2, const btTransform& place,
                std::unique_ptr<btCollisionShape> shape) {
    btRigidBody::btRigidBodyConstructionInfo info(mass_kg, nullptr, shape.get(), inertia_kg_m2);
    info.m_startWorldTransform = place;
    info.m_friction = std::sqrt(0.5F);  // Bullet multiplies those of a pair
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(bodies_.back().get());
    shapes_.push_back(std::move(shape));
  }
  void add_joint(const dynamics::Description::Joint& joint) {
    btRigidBody& below = *bodies_[planes_ + static_cast<std::size_t>(joint.b.rigid)];
    if (joint.a.rigid < 0)
      joints_.push_back(std::make_unique<btPoint2PointConstraint>(
          below, vector_of(kUnits_per_m * joint.b.point_m)));
    else
      joints_.push_back(std::make_unique<btPoint2PointConstraint>(
          *bodies_[planes_ + static_cast<std::size_t>(joint.a.rigid)], below,
          vector_of(kUnits_per_m * joint.a.point_m), vector_of(kUnits_per_m * joint.b.point_m)));
    world_.addConstraint(joints_.back().get(), true);
  }

  int substeps_;
  std::size_t planes_ = 0;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btTypedConstraint>> joints_;
};

}  // namespace

std::unique_ptr<PeerWorld> bullet_world(const PeerScene& scene, BulletMethod method) {
  return std::make_unique<BulletWorld>(scene, method);
}

double overlap_mm(const PeerScene& scene, std::span<const Pose> poses) {
  PeerScene posed = scene;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    posed.ours.state.rigid_position_m[i] = dynamics::Vector4(poses[i].position_m);
    posed.ours.state.orientation[i] = dynamics::Vector4(poses[i].orientation);
  }
  BulletWorld ruler(posed, {});
  const std::vector<double> depths_m = ruler.depths_m();
  double sum_m = 0.0;
  for (const double depth_m : depths_m) sum_m += depth_m;
  return 1e3 * sum_m / static_cast<double>(std::max<std::size_t>(1, depths_m.size()));
}

}  // namespace stillgrid::performance
