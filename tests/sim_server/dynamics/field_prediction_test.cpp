// What a snapshot tells of bodies that are met through fields: docs/algorithms/predict.md.

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/field_worlds.hpp"

namespace stillgrid::dynamics::field_prediction_test {
namespace {

using Eigen::Vector3d;
using scene::IntegratorKind;

constexpr double kStep_s = 0.0113, kStiffness_N_per_m = 700.0, kMass_kg = 0.137, kTool_m = 0.0051;
const Vector3d kSize_m(0.061, 0.047, 0.033);

Vector3d vector(const std::array<float, 3>& v) {
  return Eigen::Map<const Eigen::Vector3f>(v.data()).cast<double>();
}

/// Boxes of fields, free in the air, a tool of one sphere.
struct Air {
  scene::SceneDescription scene;
  bodies::World world;
};
Air air(const IntegratorKind& integrator, int boxes = 1, double gravity_m_s2 = 0.0) {
  std::vector<bodies::BodyDescription> bodies;
  for (int i = 0; i < boxes; ++i)
    bodies.push_back(sim_server::points_body(sim_server::box_points(kSize_m, 4, 0.0011), kSize_m,
                                             kMass_kg, {0.07 * i, 0.003 * i, 0.037 * (i % 2)}));
  if (gravity_m_s2 > 0.0) bodies.push_back(sim_server::floor_at(-0.5 * kSize_m.z()));
  Air air{sim_server::scene_of(bodies, sim_server::material_of(kStiffness_N_per_m, 1.0, 0.4),
                               {0, 0, -gravity_m_s2}),
          {}};
  air.scene.tool = {{Vector3d::Zero(), kTool_m}};
  air.scene.method.integrator = integrator;
  air.scene.method.tolerance_m_s = 1e-10;
  air.world = scene::build_world(air.scene);
  for (int i = 0; i < boxes; ++i)
    sim_server::meet_by_field(air.world, i, sim_server::box_field(kSize_m, 0.0015, 0.012));
  return air;
}

StepReport step_with_tool(Simulation& simulation, const Vector3d& at_m) {
  ToolSample sample;
  sample.time_ns = static_cast<std::uint64_t>((simulation.world().time_s + kStep_s) * 1e9);
  sample.position_m = at_m;
  return simulation.step(kStep_s, [&]() -> std::optional<ToolSample> { return sample; });
}

TEST_CASE("Records of a field follow its body, newest first, one of each step", "[field]") {
  Air own = air(IntegratorKind::kVelocityVerlet, 2);
  own.world.rigid_bodies[1].velocity_m_s = {0.02, -0.05, 0.3};
  own.world.rigid_bodies[1].angular_velocity_rad_s = {1.0, -3.0, 2.0};
  Simulation simulation(own.scene, own.world);
  REQUIRE(simulation.field_records().size() == 2);
  std::vector<bodies::RigidBody> states{simulation.world().rigid_bodies[1]};
  for (int i = 0; i < 7; ++i) {
    REQUIRE(advance(simulation, kStep_s, 1));
    states.push_back(simulation.world().rigid_bodies[1]);
    const proto::FieldRecord& record = simulation.field_records()[1];
    for (std::size_t age = 0; age < record.history.size(); ++age) {
      const bodies::RigidBody& then = states[states.size() - 1 - std::min(age, states.size() - 1)];
      CHECK((vector(record.history[age].position_m) - then.position_m).norm() < 1e-7);
      CHECK((vector(record.history[age].velocity_m_s) - then.velocity_m_s).norm() < 1e-6);
      CHECK((vector(record.history[age].angular_velocity_rad_s) - then.angular_velocity_rad_s)
                .norm() < 1e-6);
      const auto& q = record.history[age].orientation_xyzw;
      CHECK(std::abs(then.orientation.coeffs().dot(
                Eigen::Vector4f(q[0], q[1], q[2], q[3]).cast<double>())) ==
            Approx(1.0).margin(1e-6));
    }
    CHECK(record.predicted_velocity_m_s == record.history[0].velocity_m_s);
    CHECK(record.response == 0);
  }
}

TEST_CASE("A field is predicted the end of its next step under the tool's force as it is",
          "[field]") {
  const auto kind = GENERATE(IntegratorKind::kImplicitEuler, IntegratorKind::kVelocityVerlet);
  Air own = air(kind);
  own.world.rigid_bodies[0].velocity_m_s = {0.01, 0.02, -0.03};
  own.world.rigid_bodies[0].angular_velocity_rad_s = {0.4, -0.2, 0.3};
  Simulation simulation(own.scene, own.world);
  const Vector3d at_m(0.013, -0.008, 0.5 * kSize_m.z() + kTool_m - 0.0017);
  (void)step_with_tool(simulation, at_m);
  const publication::SnapshotPrediction prediction = simulation.predict_next(kStep_s);
  const proto::FieldRecord record = simulation.field_records()[0];
  REQUIRE(record.response > 0);
  REQUIRE(record.response + 1 <= prediction.responses.size());

  // What the tool pushes with: P^2 / m moves the origin, P^2 / I turns it.
  const bodies::RigidBody body = simulation.world().rigid_bodies[0];
  const bodies::FieldBody& field = simulation.world().fields[0];
  const contact::FieldTouch touch = contact::touch_of(
      field, contact::pose_of(field, simulation.world().rigid_bodies), at_m, kTool_m);
  REQUIRE(touch.depth_m > 1e-4);
  const Eigen::Matrix3d turn_per_torque =
      kStep_s * kStep_s * bodies::world_inertia_kg_m2(body).inverse();
  Eigen::Matrix3d moves = Eigen::Matrix3d::Zero(), turns = Eigen::Matrix3d::Zero();
  for (std::size_t mode = 0; mode < prediction.modes.size(); ++mode) {
    const Vector3d move = vector(prediction.responses[record.response - 1].modes[mode]);
    const Vector3d turn = vector(prediction.responses[record.response].modes[mode]);
    moves += move * move.transpose();
    turns += turn * turn.transpose();
  }
  const double move_per_N = kStep_s * kStep_s / kMass_kg;
  CHECK((moves - move_per_N * Eigen::Matrix3d::Identity()).norm() < 1e-4 * move_per_N);
  // Inertia turns with the body within the step.
  CHECK((turns - turn_per_torque).norm() < 0.03 * turn_per_torque.norm());

  // With no friction to speak of: where springs alone push.
  const Vector3d force_N =
      -kStiffness_N_per_m * touch.stiffness_scale * touch.depth_m * touch.normal;
  const Vector3d expected_m_s = body.velocity_m_s + kStep_s / kMass_kg * force_N;
  CHECK((vector(record.predicted_velocity_m_s) - expected_m_s).norm() <
        0.3 * kStep_s / kMass_kg * force_N.norm());
  const Vector3d arm_m = at_m - kTool_m * touch.normal - body.position_m;
  const Vector3d spun_rad_s =
      kStep_s * bodies::world_inertia_kg_m2(body).inverse() * arm_m.cross(force_N);
  CHECK((vector(record.predicted_angular_velocity_rad_s) - body.angular_velocity_rad_s - spun_rad_s)
            .norm() < 0.35 * spun_rad_s.norm());
}

/// Every number of the world that moves.
std::vector<double> state_of(const bodies::World& world) {
  std::vector<double> state;
  for (const bodies::RigidBody& body : world.rigid_bodies)
    for (const auto& v : {body.position_m, body.velocity_m_s, body.angular_velocity_rad_s,
                          Vector3d(body.orientation.vec())})
      state.insert(state.end(), v.data(), v.data() + 3);
  return state;
}

TEST_CASE("Who predicts a scene of fields moves it to the same bits", "[field]") {
  const auto kind = GENERATE(IntegratorKind::kImplicitEuler, IntegratorKind::kVelocityVerlet);
  const Air own = air(kind, 5, 9.79);
  Simulation watched(own.scene, own.world), alone(own.scene, own.world);
  watched.account_energy();
  int most_contacts = 0;
  for (int i = 0; i < 150; ++i) {
    const double time_s = i * kStep_s;
    const Vector3d at_m(0.14 + 0.1 * std::sin(3.0 * time_s), 0.01 * std::cos(7.0 * time_s),
                        0.03 - 0.02 * std::cos(5.0 * time_s));
    const StepReport report = step_with_tool(watched, at_m);
    const StepReport other = step_with_tool(alone, at_m);
    (void)watched.predict_next(kStep_s);
    if (i % 7 == 0) (void)watched.energy_account();
    most_contacts = std::max(most_contacts, report.contacts);
    REQUIRE(report.tools[0].work_J == other.tools[0].work_J);
    REQUIRE(state_of(watched.world()) == state_of(alone.world()));
  }
  CHECK(most_contacts > 20);
}

}  // namespace
}  // namespace stillgrid::dynamics::field_prediction_test
