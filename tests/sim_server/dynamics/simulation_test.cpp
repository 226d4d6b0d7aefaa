#include "sim_server/dynamics/step/simulation.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <random>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::simulation_test {
namespace {

constexpr double kStep_s = 0.01;

bodies::BodyDescription driven_ball(const bodies::PrescribedMotion& motion) {
  bodies::BodyDescription body = sim_server::sphere({0, 0, 0}, 0.02, 0.0);
  body.motion = bodies::Motion::kPrescribed;
  body.prescribed = motion;
  return body;
}

TEST_CASE("A scene where nothing is free steps all the same", "[simulation]") {
  bodies::BodyDescription net = sim_server::sheet({3, 3}, 0.1, 0.01, 10.0);
  sim_server::springs(net).pinned_nodes = {0, 1, 2, 3, 4, 5, 6, 7, 8};
  const scene::SceneDescription scene =
      GENERATE_COPY(sim_server::scene_of({}), sim_server::scene_of({sim_server::floor_at(0.0)}),
                    sim_server::scene_of({net}, {}, {0, 0, -9.81}),
                    sim_server::scene_of({net, driven_ball({.velocity_m_s = {0.1, 0.0, 0.0}})}));
  Simulation simulation(scene);

  const StepReport report = simulation.step(kStep_s, no_tool);

  CHECK(report.solve.converged);
  CHECK(simulation.world().time_s == kStep_s);
  for (const bodies::Node& node : simulation.world().nodes) CHECK(node.velocity_m_s.isZero(0.0));
}

TEST_CASE("The tool may touch a scene where nothing is free", "[simulation]") {
  bodies::BodyDescription net = sim_server::sheet({2, 2}, 0.1, 0.01, 10.0);
  sim_server::springs(net).pinned_nodes = {0, 1, 2, 3};
  scene::SceneDescription scene =
      sim_server::scene_of({net}, sim_server::material_of(100.0, 1.0, 0.5));
  scene.tool = {{Eigen::Vector3d::Zero(), 0.05}};
  Simulation simulation(scene);
  const auto tool = [] { return ToolSample{.time_ns = 5, .position_m = {0.05, 0.05, 0.02}}; };

  CHECK(simulation.step(kStep_s, tool).solve.converged);
}

TEST_CASE("A pinned body stays while others collide with it", "[simulation]") {
  bodies::BodyDescription net = sim_server::sheet({4, 4}, 0.02, 0.01, 10.0);
  for (int i = 0; i < 16; ++i) sim_server::springs(net).pinned_nodes.push_back(i);
  Simulation simulation(sim_server::scene_of(
      {net, sim_server::moving(sim_server::sphere({0, 0, 0.03}, 0.01, 0.05), {0, 0, -0.5})},
      sim_server::material_of(1000.0)));
  const bodies::World start = simulation.world();
  CHECK(advance(simulation, 0.002, 100));

  for (std::size_t i = 0; i < start.nodes.size(); ++i)
    CHECK(simulation.world().nodes[i].position_m == start.nodes[i].position_m);
  CHECK(simulation.world().rigid_bodies[0].velocity_m_s.z() > 0.2);  // it bounced
}

TEST_CASE("A prescribed body is where its motion says at every step's end", "[simulation]") {
  const auto keyframes = std::make_shared<const bodies::PrescribedMotion::Keyframes>(
      bodies::PrescribedMotion::Keyframes{{0.1, {0, 0, 0.03}}, {0.15, {0, 0, 0.03}}});
  const auto motion = GENERATE_COPY(
      bodies::PrescribedMotion{
          .direction = Eigen::Vector3d::UnitZ(), .amplitude_m = 0.03, .frequency_hz = 2.0},
      bodies::PrescribedMotion{.keyframes = keyframes});
  Simulation simulation(
      sim_server::scene_of({driven_ball(motion), sim_server::sphere({0, 0, 0.041}, 0.02, 0.1)},
                           sim_server::material_of(1000.0)));

  for (int i = 1; i <= 40; ++i) {
    CHECK(advance(simulation, kStep_s, 1));
    const bodies::RigidBody& ball = simulation.world().rigid_bodies[0];
    const bodies::PrescribedState state = bodies::prescribed_state(ball, simulation.world().time_s);
    CHECK(ball.position_m == state.position_m);
    CHECK(ball.velocity_m_s == state.velocity_m_s);
  }
  CHECK(simulation.world().rigid_bodies[1].velocity_m_s.z() > 0.1);  // it was struck
}

TEST_CASE("A tool without a proxy pushes what it touches, as the contact law says",
          "[simulation]") {
  scene::SceneDescription scene = sim_server::scene_of({sim_server::sphere({0, 0, 0}, 0.01, 0.1)},
                                                       sim_server::material_of(100.0));
  scene.tool = {{Eigen::Vector3d(0, 0, 0.005), 0.01}};
  scene.tool_slip_speed_m_s = scene::kPenaltySlip_m_s;
  Simulation simulation(scene);
  // Turned upside down the tool's sphere is 15 mm below the ball: 5 mm deep.
  const ToolSample sample{77, {0, 0, -0.01}, Eigen::Quaterniond(0, 1, 0, 0), {0, 0, 0}};

  const StepReport report = simulation.step(kStep_s, [&] { return sample; });

  CHECK(report.tools[0].time_ns == 77);
  CHECK(report.contacts == 1);
  // m v = h k (5 mm - h v)
  const double expected_m_s = kStep_s * 100.0 * 0.005 / (0.1 + kStep_s * kStep_s * 100.0);
  CHECK(simulation.world().rigid_bodies[0].velocity_m_s.z() == Approx(expected_m_s));
}

TEST_CASE("A rubbing tool without a proxy drags what it touches along", "[simulation]") {
  scene::SceneDescription scene = sim_server::scene_of({sim_server::sphere({0, 0, 0}, 0.01, 0.1)},
                                                       sim_server::material_of(100.0, 0.0, 0.5));
  scene.tool = {{Eigen::Vector3d::Zero(), 0.01}};
  scene.tool_slip_speed_m_s = scene::kPenaltySlip_m_s;
  scene.method.tolerance_m_s = 1e-11;  // of speeds of a quarter of a millimetre a second
  Simulation simulation(scene);

  (void)simulation.step(1e-4, [] {
    return ToolSample{.time_ns = 1, .position_m = {0, 0, 0.015}, .velocity_m_s = {1, 0, 0}};
  });

  const bodies::RigidBody& ball = simulation.world().rigid_bodies[0];
  // Sliding: half of the pressure, sideways, at the ball's top, which spins it forwards. The tool
  // comes from 0.1 mm aside, so that both forces of the step are half of that aslant.
  CHECK(ball.velocity_m_s.z() < 0.0);
  const double aslant = 0.5e-4 / 0.015;
  const double pressed_m_s = -ball.velocity_m_s.z() / (1.0 - 0.5 * aslant);
  const double dragged_m_s = 0.5 * pressed_m_s;
  CHECK(ball.velocity_m_s.x() == Approx(dragged_m_s + aslant * pressed_m_s).epsilon(1e-4));
  CHECK(ball.angular_velocity_rad_s.y() ==
        Approx(0.1 * dragged_m_s * 0.0075 / (0.4 * 0.1 * 0.01 * 0.01)).epsilon(1e-4));
}

TEST_CASE("The tool is asked for once in a tick", "[simulation]") {
  Simulation simulation(sim_server::scene_of(
      {sim_server::sphere({0, 0, 0}, 0.01, 0.1), sim_server::sphere({0, 0, 0.015}, 0.01, 0.1)}));
  int asked = 0;

  const StepReport report = simulation.step(kStep_s, [&]() -> std::optional<ToolSample> {
    ++asked;
    return std::nullopt;
  });

  CHECK(asked == 1);
  CHECK(report.tools[0].time_ns == 0);
}

TEST_CASE("A step reports the contacts that touch and what it costs", "[simulation]") {
  Simulation simulation(sim_server::scene_of(
      {sim_server::sphere({0, 0, 0}, 0.01, 0.1), sim_server::sphere({0, 0, 0.015}, 0.01, 0.1),
       sim_server::sphere({0, 0, 0.0355}, 0.01, 0.1)},
      sim_server::material_of(100.0)));

  const StepReport report = simulation.step(1e-4, no_tool);

  CHECK(report.contacts == 1);
  CHECK(report.integrate.count() > 0);
}

/// A block that comes down on the floor, sliding and turning a little.
scene::SceneDescription landing(double stiffness_N_per_m, double approach_m_s) {
  bodies::BodyDescription block =
      sim_server::box({0, 0, 0.021}, {0.03, 0.03, 0.04}, 0.02, {0.01, 0.005});
  return sim_server::scene_of(
      {sim_server::moving(block, {0.4, 0, -approach_m_s}, {0.5, 0, 0}), sim_server::floor_at(0.0)},
      sim_server::material_of(stiffness_N_per_m, 0.0035 * std::sqrt(stiffness_N_per_m), 0.5),
      {0, 0, -9.81});
}

TEST_CASE("A block lands on a stiff floor step by step, by substeps if need be", "[simulation]") {
  // k h^2 / m of a sphere up to 3000, and nine of them touch at once.
  const double stiffness_N_per_m = GENERATE(5e2, 5e3, 5e4), approach_m_s = GENERATE(0.1, 1.0);
  const double step_s = GENERATE(0.01, 0.033);
  Simulation simulation(landing(stiffness_N_per_m, approach_m_s));
  const double start_J = bodies::mechanical_energy_J(simulation.world());

  for (int i = 0; i < 60; ++i) {
    REQUIRE(advance(simulation, step_s, 1));
    CHECK(bodies::mechanical_energy_J(simulation.world()) <= start_J + 1e-9);
  }

  CHECK(simulation.world().rigid_bodies[0].velocity_m_s.norm() < 1e-3);
  // At rest on one face or another: whether it tips over hangs on the step.
  const double height_m = simulation.world().rigid_bodies[0].position_m.z();
  CHECK(height_m == Approx(height_m > 0.0175 ? 0.02 : 0.015).margin(1e-4));
}

// A floor of 5e5 N/m against 20 g: substeps of an eighth still need more iterations than usual.
TEST_CASE("A very stiff floor does not throw a block that lands on it", "[simulation]") {
  const double approach_m_s = GENERATE(0.1, 3.0);
  Simulation simulation(landing(5e5, approach_m_s));
  const double start_J = bodies::mechanical_energy_J(simulation.world());

  (void)advance(simulation, 0.033, 60);

  CHECK(bodies::mechanical_energy_J(simulation.world()) <= start_J + 1e-9);
}

TEST_CASE("The same scene moves the same way, bit for bit", "[simulation]") {
  bodies::BodyDescription cloth = sim_server::sheet({5, 5}, 0.02, 0.002, 500.0);
  sim_server::springs(cloth).pinned_nodes = {0, 4};
  const scene::SceneDescription scene = sim_server::scene_of(
      {cloth, sim_server::box({0, 0, 0.03}, {0.03, 0.03, 0.02}, 0.02, {0.01, 0.005}),
       sim_server::floor_at(-0.05)},
      sim_server::material_of(500.0, 1.0, 0.3), {0, 0, -9.81});
  Simulation one(scene), other(scene);
  for (int i = 0; i < 50; ++i) {
    (void)advance(one, kStep_s, 1);
    (void)advance(other, kStep_s, 1);
  }

  for (std::size_t i = 0; i < one.world().nodes.size(); ++i)
    CHECK(one.world().nodes[i].position_m == other.world().nodes[i].position_m);
  CHECK(one.world().rigid_bodies[0].position_m == other.world().rigid_bodies[0].position_m);
}

/// What two blocks that are let go half a millimetre into each other and the floor have more of
/// energy than at their start, after five seconds, J. They have 5.6 mJ of height.
double gained_by_stacked_blocks_J(scene::IntegratorKind integrator) {
  const bodies::SpherePacking spheres{0.01, 0.005};
  scene::SceneDescription scene =
      sim_server::scene_of({sim_server::floor_at(0.0),
                            sim_server::box({0, 0, 0.0095}, {0.03, 0.03, 0.02}, 0.02, spheres),
                            sim_server::box({0.002, 0, 0.0285}, {0.03, 0.03, 0.02}, 0.02, spheres)},
                           sim_server::material_of(2000.0, 0.2, 0.5), {0, 0, -9.81});
  scene.method.integrator = integrator;
  Simulation simulation(scene);
  simulation.account_energy();
  for (int i = 0; i < 165; ++i) (void)simulation.step(1.0 / 33.0, no_tool);
  const EnergyAccount account = *simulation.energy_account();
  return account.end.total_J() - account.start.total_J();
}

TEST_CASE("Blocks on each other come to less energy than they began with", "[simulation]") {
  for (const scene::IntegratorKind integrator :
       {scene::IntegratorKind::kImplicitEuler, scene::IntegratorKind::kVelocityVerlet})
    CHECK(gained_by_stacked_blocks_J(integrator) < 0.0);
}

TEST_CASE("A settled block lies on as it lay where its world is copied with what sticks",
          "[simulation]") {
  const double slope_rad = 0.26;
  scene::SceneDescription scene = sim_server::scene_of(
      {sim_server::floor_at(0.0),
       sim_server::box({0, 0, 0.0099}, {0.03, 0.03, 0.02}, 0.05, {0.01, 0.005})},
      sim_server::material_of(1000.0, 2.0, 0.5),
      {9.81 * std::sin(slope_rad), 0, -9.81 * std::cos(slope_rad)});
  scene.sleeping = false;
  Simulation settled(scene);
  for (int i = 0; i < 300; ++i) (void)settled.step(kStep_s, no_tool);
  const Eigen::Vector3d start_m = settled.world().rigid_bodies[0].position_m;

  double moved_m[2] = {};
  for (const bool sticks : {false, true}) {
    Simulation copy(scene, settled.world());
    if (sticks) copy.set_contact_state(settled.contact_state());
    for (int i = 0; i < 30; ++i) {
      (void)copy.step(kStep_s, no_tool);
      moved_m[sticks] =
          std::max(moved_m[sticks], (copy.world().rigid_bodies[0].position_m - start_m).norm());
    }
  }

  CHECK(moved_m[false] > 1e-6);  // it falls back into its stretch
  CHECK(moved_m[true] < 1e-8);
}

}  // namespace
}  // namespace stillgrid::dynamics::simulation_test
