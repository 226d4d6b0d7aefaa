// A pile of nine boxes in Bullet, each felt as a compound of spheres, at 1 kHz.
//
//   publish_bullet SESSION [--lockstep]
//
// Beside it: haptic_server --session SESSION --device ..., with --lockstep if this has it.
#include <btBulletDynamicsCommon.h>
#include <stillgrid/stillgrid.h>

#include <algorithm>
#include <array>
#include <cmath>
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

/// Where a body is, and how it moves.
struct State {
  btTransform pose;
  btVector3 velocity_m_s, turning_rad_s;
};

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
    const stillgrid_material material{800.0, 1.0, 0.4, 0.01};
    const stillgrid_plane floor{{0.0, 0.0, 1.0}, kFloor_m, 0, 0};
    const auto count = static_cast<std::uint32_t>(spheres_.size() * (bodies_.size() - 1));
    stillgrid_scene scene{};
    scene.struct_size = sizeof scene;
    scene.clock = is_lockstep ? STILLGRID_VIRTUAL_TIME : STILLGRID_REAL_TIME;
    scene.session = session;
    scene.name = "pile of boxes";
    scene.period_s = kPeriod_s;
    scene.sphere_capacity = count;
    scene.predicts = 1;
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
    for (std::uint64_t time_ns = 0;;) {
      const int code = stillgrid_publisher_wait(publisher_, &time_ns);
      require(code, "wait");
      if (code == STILLGRID_AGAIN) continue;
      if (code == STILLGRID_NOTHING) break;
      place(positions_m_, &velocities_m_s_);
      require(stillgrid_publisher_set_spheres(publisher_, count(), positions_m_.data(),
                                              velocities_m_s_.data()),
              "set_spheres");
      tell_responses();
      take_pushes();
      for (int i = 0; i < kSteps; ++i) step();
      place(after_m_, nullptr);
      tell(stillgrid_publisher_set_predicted, "set_predicted");
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

  [[nodiscard]] std::uint32_t count() const {
    return static_cast<std::uint32_t>(positions_m_.size() / 3);
  }

  void place(std::vector<double>& positions_m, std::vector<double>* velocities_m_s) {
    positions_m.clear();
    if (velocities_m_s != nullptr) velocities_m_s->clear();
    for (std::size_t b = 1; b < bodies_.size(); ++b) {
      const btTransform& pose = bodies_[b]->getWorldTransform();
      for (const btVector3& centre_m : spheres_) {
        const btVector3 arm_m = pose.getBasis() * centre_m, at_m = pose.getOrigin() + arm_m;
        positions_m.insert(positions_m.end(), {at_m.x(), at_m.y(), at_m.z()});
        if (velocities_m_s == nullptr) continue;
        const btVector3 v_m_s = bodies_[b]->getVelocityInLocalPoint(arm_m);
        velocities_m_s->insert(velocities_m_s->end(), {v_m_s.x(), v_m_s.y(), v_m_s.z()});
      }
    }
  }

  /// A period with the pushes of the one before and a wrench on one body, after which all is as
  /// it was. Where that body's centre and turn were led.
  [[nodiscard]] std::array<double, 6> try_period(btRigidBody& body, const btVector3& force_N,
                                                 const btVector3& torque_N_m) {
    saved_.clear();
    for (const auto& one : bodies_)
      saved_.push_back(
          {one->getWorldTransform(), one->getLinearVelocity(), one->getAngularVelocity()});
    const btTransform before = body.getWorldTransform();
    for (int i = 0; i < kSteps; ++i) {
      body.applyCentralForce(force_N);
      body.applyTorque(torque_N_m);
      step();
    }
    const btTransform after = body.getWorldTransform();
    place(after_m_, nullptr);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      bodies_[i]->setWorldTransform(saved_[i].pose);
      bodies_[i]->setInterpolationWorldTransform(saved_[i].pose);
      bodies_[i]->setLinearVelocity(saved_[i].velocity_m_s);
      bodies_[i]->setAngularVelocity(saved_[i].turning_rad_s);
    }
    const btVector3 way_m = after.getOrigin() - before.getOrigin();
    const btQuaternion turn =
        (after.getRotation() * before.getRotation().inverse()).nearest(btQuaternion::getIdentity());
    return {way_m.x(), way_m.y(), way_m.z(), 2.0 * turn.x(), 2.0 * turn.y(), 2.0 * turn.z()};
  }

  /// Of the inertia; a force held through n small steps moves a mass by (1 + 1 / n) / 2 of what one
  /// implicit step says.
  [[nodiscard]] stillgrid_response response_of(std::size_t b) const {
    const double share = 0.5 * (1.0 + 1.0 / kSteps);
    stillgrid_response response{};
    response.body = static_cast<std::uint32_t>(b);
    const btMatrix3x3& turning = bodies_[b]->getInvInertiaTensorWorld();
    for (int i = 0; i < 3; ++i) {
      response.centre_m[i] = bodies_[b]->getCenterOfMassPosition()[i];
      response.inverse_inertia[7 * i] = share * bodies_[b]->getInvMass();
      for (int j = 0; j < 3; ++j)
        response.inverse_inertia[6 * (3 + i) + 3 + j] =
            share * 0.5 * (turning[i][j] + turning[j][i]);
    }
    return response;
  }

  /// Less, where what a body lies on resists: as much as trials of a period show, an axis at a
  /// time.
  void hold_back(stillgrid_response& response, const std::array<double, 6>& still) {
    btRigidBody& body = *bodies_[response.body];
    std::array<double, 6> share{};
    for (int axis = 0; axis < 6; ++axis) {
      const double wrench = axis < 3 ? 2.0 * kMass_kg : 2.0 * kMass_kg * kHalf_m;
      btVector3 force_N(0, 0, 0), torque_N_m(0, 0, 0);
      (axis < 3 ? force_N : torque_N_m)[axis % 3] = wrench;
      // What a body lies on resists one way; both ways count.
      const double up = try_period(body, force_N, torque_N_m)[axis] - still[axis];
      const double down = still[axis] - try_period(body, -force_N, -torque_N_m)[axis];
      const double free = wrench * kPeriod_s * kPeriod_s * response.inverse_inertia[7 * axis];
      share[axis] = std::sqrt(std::clamp(std::min(up, down) / free, 1e-3, 1.0));
    }
    for (int i = 0; i < 36; ++i) response.inverse_inertia[i] *= share[i / 6] * share[i % 6];
  }

  void tell_responses() {
    std::vector<stillgrid_response> responses;
    for (std::size_t b = 1; b < bodies_.size(); ++b) responses.push_back(response_of(b));
    for (const stillgrid_push& push : pushes_)
      if (push.body != 0)
        hold_back(responses[push.body - 1],
                  try_period(*bodies_[push.body], btVector3(0, 0, 0), btVector3(0, 0, 0)));
    (void)try_period(*bodies_[1], btVector3(0, 0, 0), btVector3(0, 0, 0));
    tell(stillgrid_publisher_set_trial, "set_trial");
    require(stillgrid_publisher_set_responses(
                publisher_, static_cast<std::uint32_t>(responses.size()), responses.data()),
            "set_responses");
  }

  /// The mean velocities over the period that led to after_m_.
  void tell(decltype(stillgrid_publisher_set_trial) set, const char* name) {
    for (std::size_t i = 0; i < after_m_.size(); ++i)
      after_m_[i] = (after_m_[i] - positions_m_[i]) / kPeriod_s;
    require(set(publisher_, count(), after_m_.data()), name);
  }

  void take_pushes() {
    pushes_.resize(kMaxPushes);
    std::uint32_t count = kMaxPushes;
    require(stillgrid_publisher_pushes(publisher_, kPeriod_s, pushes_.data(), &count), "pushes");
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
  std::vector<double> positions_m_, velocities_m_s_, after_m_;
  std::vector<stillgrid_push> pushes_;  // of the period before, until there are those of this one
  std::vector<State> saved_;
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
