#include "tests/performance/work_precision_bullet.hpp"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>

#include <memory>

#include "sim_server/scene/build_world.hpp"

namespace stillgrid::performance {
namespace {

static_assert(sizeof(btScalar) == sizeof(double));

/// Bullet's mass-spring force knows one stiffness and one for bending; here each link has its own,
/// kept in its material. Line for line Bullet's otherwise.
class LinkForce : public btDeformableMassSpringForce {
 public:
  LinkForce() : btDeformableMassSpringForce(1.0, 0.0) {}

  void addScaledElasticForce(btScalar scale, TVStack& force) override {
    for_each_link([&](const btSoftBody::Link& link, int a, int b) {
      const btVector3 apart = link.m_n[1]->m_q - link.m_n[0]->m_q;
      const btScalar length = apart.norm();
      if (length <= SIMD_EPSILON) return;
      const btVector3 pull = scale * link.m_material->m_kLST * (apart - link.m_rl / length * apart);
      force[a] += pull;
      force[b] -= pull;
    });
  }

  void addScaledElasticForceDifferential(btScalar scale, const TVStack& dx, TVStack& df) override {
    for_each_link([&](const btSoftBody::Link& link, int a, int b) {
      const btVector3 apart = link.m_n[0]->m_q - link.m_n[1]->m_q;
      const btScalar length = apart.norm();
      if (length <= SIMD_EPSILON) return;
      const btVector3 along = apart / length, change = dx[a] - dx[b];
      const btScalar stiffness = scale * link.m_material->m_kLST;
      const btScalar slack = (length - link.m_rl) / length;
      const btVector3 pull =
          -stiffness * ((1.0 - slack) * along.dot(change) * along + slack * change);
      df[a] += pull;
      df[b] -= pull;
    });
  }

  // Without damping nothing is left to add.
  void addScaledDampingForce(btScalar /*scale*/, TVStack& /*force*/) override {}
  void addScaledDampingForceDifferential(btScalar /*scale*/, const TVStack& /*dv*/,
                                         TVStack& /*df*/) override {}
  void buildDampingForceDifferentialDiagonal(btScalar /*scale*/, TVStack& /*diagonal*/) override {}

 private:
  template <class Visit>
  void for_each_link(Visit visit) {
    for (int i = 0; i < m_softBodies.size(); ++i) {
      const btSoftBody& body = *m_softBodies[i];
      for (int j = 0; j < body.m_links.size(); ++j) {
        const btSoftBody::Link& link = body.m_links[j];
        visit(link, link.m_n[0]->index, link.m_n[1]->index);
      }
    }
  }
};

btVector3 vector_of(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

/// A world of ours, of masses and springs only, as Bullet's.
class BulletWorld {
 public:
  BulletWorld(const bodies::World& world, bool implicit)
      : dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &constraint_solver_, &configuration_, &solver_),
        gravity_(vector_of(world.gravity_m_s2)) {
    constraint_solver_.setDeformableSolver(&solver_);
    world_.setGravity(gravity_.m_gravity);
    world_.getWorldInfo().m_gravity = gravity_.m_gravity;
    world_.setImplicit(implicit);
    world_.setLineSearch(false);
    world_.setUseProjection(true);
    std::vector<btVector3> places;
    std::vector<btScalar> masses;
    for (const bodies::Node& node : world.nodes) {
      places.push_back(vector_of(node.position_m));
      masses.push_back(node.pinned ? 0.0 : node.mass_kg);
    }
    body_ = std::make_unique<btSoftBody>(&world_.getWorldInfo(), static_cast<int>(places.size()),
                                         places.data(), masses.data());
    for (const bodies::Spring& spring : world.springs) {
      body_->appendLink(spring.a, spring.b, material_of(spring.stiffness_N_per_m));
      body_->m_links[body_->m_links.size() - 1].m_rl = spring.rest_length_m;
    }
    for (std::size_t i = 0; i < world.nodes.size(); ++i)
      body_->m_nodes[static_cast<int>(i)].m_v = vector_of(world.nodes[i].velocity_m_s);
    body_->m_cfg.collisions = 0;
    body_->setActivationState(DISABLE_DEACTIVATION);
    world_.addSoftBody(body_.get());
    world_.addForce(body_.get(), &springs_);
    world_.addForce(body_.get(), &gravity_);
  }
  ~BulletWorld() { world_.removeSoftBody(body_.get()); }
  BulletWorld(const BulletWorld&) = delete;
  BulletWorld& operator=(const BulletWorld&) = delete;
  BulletWorld(BulletWorld&&) = delete;
  BulletWorld& operator=(BulletWorld&&) = delete;

  void step(double step_s) { world_.stepSimulation(step_s, 0); }
  void stop() {
    for (int i = 0; i < body_->m_nodes.size(); ++i) body_->m_nodes[i].m_v.setZero();
  }
  [[nodiscard]] Eigen::Matrix3Xd positions_m() const {
    Eigen::Matrix3Xd places_m(3, body_->m_nodes.size());
    for (int i = 0; i < body_->m_nodes.size(); ++i) {
      const btVector3& x = body_->m_nodes[i].m_x;
      places_m.col(i) = Eigen::Vector3d(x.x(), x.y(), x.z());
    }
    return places_m;
  }

 private:
  btSoftBody::Material* material_of(double stiffness_N_per_m) {
    for (int i = 0; i < body_->m_materials.size(); ++i)
      if (body_->m_materials[i]->m_kLST == stiffness_N_per_m) return body_->m_materials[i];
    btSoftBody::Material* material = body_->appendMaterial();
    material->m_kLST = stiffness_N_per_m;
    return material;
  }

  btSoftBodyRigidBodyCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btDeformableMultiBodyConstraintSolver constraint_solver_;
  btDeformableBodySolver solver_;
  btDeformableMultiBodyDynamicsWorld world_;
  LinkForce springs_;
  btDeformableGravityForce gravity_;
  std::unique_ptr<btSoftBody> body_;
};

}  // namespace

RunResult run_bullet(const ChartScene& scene, const ChartPoint& point, double limit_s) {
  BulletWorld bullet(scene::build_world(scene.scene), point.solver != "explicit");
  return run_through(
      scene, point.period_s, limit_s,
      [&](RunResult& run) {
        bullet.step(point.period_s);
        ++run.substeps;
      },
      [&] { return bullet.positions_m(); });
}

Eigen::Matrix3Xd bullet_at_rest_m(const scene::SceneDescription& scene, double step_s, int steps) {
  BulletWorld bullet(scene::build_world(scene), true);
  for (int i = 0; i < steps; ++i) {
    bullet.step(step_s);
    bullet.stop();
  }
  return bullet.positions_m();
}

std::vector<Curve> bullet_curves(const ChartScene& scene) {
  if (!is_conservative(scene)) return {};
  std::vector<Curve> curves(2);
  for (const double step_s : {0.01, 0.005, 0.0025, 0.001, 0.0005})
    curves[0].push_back({"bullet", "implicit", "step_s", step_s, step_s, {}});
  for (const double step_s : {0.001, 0.0005, 0.00025, 0.0001, 0.00005, 0.000025, 0.00001})
    curves[1].push_back({"bullet", "explicit", "step_s", step_s, step_s, {}});
  return curves;
}

}  // namespace stillgrid::performance
