// A pile of nine boxes in Bullet, each felt as a compound of spheres, at 1 kHz.
//
//   publish_bullet SESSION [--lockstep]
//
// Beside it: haptic_server --session SESSION --device ..., with --lockstep if this has it.
#include <btBulletDynamicsCommon.h>
#include <stillgrid/stillgrid.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

namespace {

constexpr int kSteps = 4;  // of Bullet in a period
constexpr double kPeriod_s = 1.0 / 60.0;
constexpr double kHalf_m = 0.02, kRadius_m = 0.01, kMass_kg = 0.2, kFloor_m = -0.1;
constexpr std::uint32_t kMaxPushes = 64;

void require(int code, const char* what) {
  if (code >= 0) return;
  std::fprintf(stderr, "publish_bullet: %s: %s\n", what, stillgrid_last_error());
  std::exit(2);
}

/// Spheres on a lattice of 3 x 3 x 3 that touch all sides, but for the one inside.
std::vector<btVector3> spheres_of_box() {
  std::vector<btVector3> out;
  for (int i = 0; i < 27; ++i)
    if (i != 13)
      out.emplace_back(btVector3(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1) * (kHalf_m - kRadius_m));
  return out;
}

class Pile {
 public:
  Pile() {
    world_.setGravity(btVector3(0.0, 0.0, -9.81));
    world_.getSolverInfo().m_splitImpulse = true;
    add(0.0, floor_, btVector3(0.0, 0.0, kFloor_m));
    for (int layer = 0; layer < 2; ++layer)
      for (int i = 0; i < 4; ++i)
        add(kMass_kg, box_,
            btVector3((i % 2 - 0.5) * 0.043, (i / 2 - 0.5) * 0.043,
                      kFloor_m + kHalf_m + 2.05 * kHalf_m * layer));
    add(kMass_kg, box_, btVector3(0.0, 0.0, kFloor_m + 5.15 * kHalf_m));
    for (int i = 0; i < 240; ++i) world_.stepSimulation(kPeriod_s / kSteps, 0);  // it settles
  }

  void open(const char* session, bool is_lockstep) {
    const stillgrid_material material{800.0, 1.0, 0.4};
    const stillgrid_plane floor{{0.0, 0.0, 1.0}, kFloor_m, 0, 0};
    const auto count = static_cast<std::uint32_t>(spheres_.size() * (bodies_.size() - 1));
    stillgrid_scene scene{};
    scene.struct_size = sizeof scene;
    scene.clock = is_lockstep ? STILLGRID_VIRTUAL_TIME : STILLGRID_REAL_TIME;
    scene.session = session;
    scene.name = "pile of boxes";
    scene.period_s = kPeriod_s;
    scene.sphere_capacity = count;
    scene.gives_inertia = 1;
    scene.material_count = 1;
    scene.materials = &material;
    scene.plane_count = 1;
    scene.planes = &floor;
    require(stillgrid_publisher_open(&scene, &publisher_), "open");
    const std::vector<double> radii_m(count, kRadius_m);
    std::vector<std::uint32_t> numbers(count);
    for (std::uint32_t i = 0; i < count; ++i)
      numbers[i] = 1 + i / static_cast<std::uint32_t>(spheres_.size());
    stillgrid_shapes shapes{};
    shapes.struct_size = sizeof shapes;
    shapes.count = count;
    shapes.radii_m = radii_m.data();
    shapes.bodies = numbers.data();
    require(stillgrid_publisher_set_shapes(publisher_, &shapes), "set_shapes");
  }

  /// One period after another, until the haptic_server of a run in virtual time ends.
  void run() {
    show();
    for (std::uint64_t time_ns = 0;;) {
      const int code = stillgrid_publisher_wait(publisher_, &time_ns);
      require(code, "wait");
      if (code == STILLGRID_AGAIN) continue;
      if (code == STILLGRID_NOTHING) break;
      for (int i = 0; i < kSteps; ++i) {
        take_pushes();
        step();
        show();
      }
      require(stillgrid_publisher_publish(publisher_, time_ns), "publish");
    }
    stillgrid_publisher_close(publisher_);
  }

 private:
  void add(double mass_kg, btCollisionShape& shape, const btVector3& position_m) {
    btVector3 inertia(0.0, 0.0, 0.0);
    if (mass_kg > 0.0) shape.calculateLocalInertia(mass_kg, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(mass_kg, nullptr, &shape, inertia);
    info.m_startWorldTransform.setOrigin(position_m);
    info.m_friction = 0.5;
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(bodies_.back().get());
  }

  void show() {
    positions_m_.clear();
    velocities_m_s_.clear();
    responses_.clear();
    for (std::size_t b = 1; b < bodies_.size(); ++b) {
      const btTransform& pose = bodies_[b]->getWorldTransform();
      for (const btVector3& centre_m : spheres_) {
        const btVector3 arm_m = pose.getBasis() * centre_m, at_m = pose.getOrigin() + arm_m;
        const btVector3 v_m_s = bodies_[b]->getVelocityInLocalPoint(arm_m);
        positions_m_.insert(positions_m_.end(), {at_m.x(), at_m.y(), at_m.z()});
        velocities_m_s_.insert(velocities_m_s_.end(), {v_m_s.x(), v_m_s.y(), v_m_s.z()});
      }
      responses_.push_back(response_of(b));
    }
    require(stillgrid_publisher_set_spheres(publisher_,
                                            static_cast<std::uint32_t>(positions_m_.size() / 3),
                                            positions_m_.data(), velocities_m_s_.data()),
            "set_spheres");
    require(stillgrid_publisher_set_responses(
                publisher_, static_cast<std::uint32_t>(responses_.size()), responses_.data()),
            "set_responses");
  }

  [[nodiscard]] stillgrid_response response_of(std::size_t b) const {
    stillgrid_response response{};
    response.body = static_cast<std::uint32_t>(b);
    const btMatrix3x3& turning = bodies_[b]->getInvInertiaTensorWorld();
    for (int i = 0; i < 3; ++i) {
      response.centre_m[i] = bodies_[b]->getCenterOfMassPosition()[i];
      response.velocity[i] = bodies_[b]->getLinearVelocity()[i];
      response.velocity[3 + i] = bodies_[b]->getAngularVelocity()[i];
      response.inverse_inertia[7 * i] = bodies_[b]->getInvMass();
      for (int j = 0; j < 3; ++j)
        response.inverse_inertia[6 * (3 + i) + 3 + j] = 0.5 * (turning[i][j] + turning[j][i]);
    }
    return response;
  }

  void take_pushes() {
    pushes_.resize(kMaxPushes);
    std::uint32_t count = kMaxPushes;
    require(stillgrid_publisher_pushes(publisher_, kPeriod_s / kSteps, pushes_.data(), &count),
            "pushes");
    pushes_.resize(count);
  }

  /// Bullet takes forces for one of its steps.
  void step() {
    for (const stillgrid_push& push : pushes_) {
      btRigidBody& body = *bodies_[push.body];
      const btVector3 force_N(push.force_N[0], push.force_N[1], push.force_N[2]);
      const btVector3 point_m(push.point_m[0], push.point_m[1], push.point_m[2]);
      body.applyForce(force_N, point_m - body.getCenterOfMassPosition());
      body.applyTorque(btVector3(push.torque_N_m[0], push.torque_N_m[1], push.torque_N_m[2]));
    }
    world_.stepSimulation(kPeriod_s / kSteps, 0);
  }

  const std::vector<btVector3> spheres_ = spheres_of_box();
  btBoxShape box_{btVector3(kHalf_m, kHalf_m, kHalf_m)};
  btStaticPlaneShape floor_{btVector3(0.0, 0.0, 1.0), 0.0};
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;  // the floor first
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<double> positions_m_, velocities_m_s_;
  std::vector<stillgrid_response> responses_;
  std::vector<stillgrid_push> pushes_;
  stillgrid_publisher* publisher_ = nullptr;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "publish_bullet: expected SESSION [--lockstep]\n");
    return 1;
  }
  Pile pile;
  pile.open(argv[1], argc > 2 && std::string(argv[2]) == "--lockstep");
  pile.run();
  return 0;
}
