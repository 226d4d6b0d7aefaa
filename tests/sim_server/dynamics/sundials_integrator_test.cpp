#include <Eigen/Eigenvalues>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::sundials_integrator_test {
namespace {

scene::SceneDescription integrated(scene::SceneDescription scene, double tolerance_m_s) {
  scene.method.integrator = scene::IntegratorKind::kCvodeBdf;
  scene.method.tolerance_m_s = tolerance_m_s;
  return scene;
}

constexpr int kMasses = 10;
constexpr double kMass_kg = 0.01, kStiffness_N_per_m = 1000.0, kLink_m = 0.1;

/// Where the masses of a chain, held at one end and stretched by 1 mm a link, are after time_s:
/// its modes, each a cosine.
Eigen::VectorXd modal_displacement_m(double time_s) {
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(kMasses, kMasses);
  for (int i = 0; i < kMasses; ++i) {
    stiffness(i, i) += kStiffness_N_per_m;
    if (i + 1 == kMasses) break;
    stiffness(i, i) += kStiffness_N_per_m;
    stiffness(i, i + 1) = stiffness(i + 1, i) = -kStiffness_N_per_m;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(stiffness / kMass_kg);
  const Eigen::VectorXd start_m = Eigen::VectorXd::LinSpaced(kMasses, 0.001, 0.001 * kMasses);
  const Eigen::VectorXd phases = modes.eigenvalues().cwiseSqrt() * time_s;
  return modes.eigenvectors() *
         phases.array().cos().matrix().cwiseProduct(modes.eigenvectors().transpose() * start_m);
}

/// The largest error of any mass at the end of any step over half a second.
double chain_error_m(double tolerance_m_s) {
  Simulation simulation(integrated(
      sim_server::scene_of({sim_server::thread(kMasses + 1, {0, 0, 0}, {kMasses * kLink_m, 0, 0},
                                               kMass_kg, kStiffness_N_per_m, {0})}),
      tolerance_m_s));
  auto& nodes = simulation.world().nodes;
  for (int i = 1; i <= kMasses; ++i) nodes[static_cast<std::size_t>(i)].position_m.x() += 0.001 * i;
  double worst_m = 0.0;
  for (int step = 1; step <= 50; ++step) {
    REQUIRE(simulation.step(0.01, no_tool).solve.converged);
    const Eigen::VectorXd exact_m = modal_displacement_m(0.01 * step);
    for (int i = 1; i <= kMasses; ++i)
      worst_m = std::max(worst_m, std::abs(nodes[static_cast<std::size_t>(i)].position_m.x() -
                                           kLink_m * i - exact_m[i - 1]));
  }
  return worst_m;
}

TEST_CASE("SUNDIALS' integrators find a chain's modes, the better the less error is tolerated",
          "[sundials]") {
  double before_m = 1.0;
  for (const double tolerance_m_s : {1e-2, 1e-4, 1e-6, 1e-8}) {
    const double error_m = chain_error_m(tolerance_m_s);
    CHECK(error_m < 0.2 * before_m);
    before_m = error_m;
  }
  CHECK(before_m < 1e-6);
}

/// A brick turned about nearly its middle axis: it tumbles.
scene::SceneDescription tumbling_brick() {
  return sim_server::scene_of(
      {sim_server::moving(sim_server::box({0, 0, 0}, {0.1, 0.2, 0.3}, 1.2, {.radius_m = 0.05}),
                          {0.1, 0, 0}, {1.0, 10.0, 0.5})});
}

Eigen::Vector3d spin_momentum(const bodies::RigidBody& body) {
  const Eigen::Matrix3d r = body.orientation.toRotationMatrix();
  return r * body.inertia_kg_m2.asDiagonal() * r.transpose() * body.angular_velocity_rad_s;
}

TEST_CASE("A tumbling brick keeps its angular momentum and its energy as closely as asked",
          "[sundials]") {
  for (const double tolerance_m_s : {1e-4, 1e-8}) {
    Simulation simulation(integrated(tumbling_brick(), tolerance_m_s));
    const bodies::World& world = simulation.world();
    const Eigen::Vector3d momentum = spin_momentum(world.rigid_bodies[0]);
    const Eigen::Vector3d spin_rad_s = world.rigid_bodies[0].angular_velocity_rad_s;
    const double energy_J = bodies::mechanical_energy_J(world);
    REQUIRE(advance(simulation, 0.01, 100));  // ten radians, over several bases of rotation

    const double turned = (spin_momentum(world.rigid_bodies[0]) - momentum).norm();
    const double lost_J = std::abs(bodies::mechanical_energy_J(world) - energy_J);
    CHECK(turned < 100.0 * tolerance_m_s * momentum.norm());
    CHECK(lost_J < 100.0 * tolerance_m_s * energy_J);
    CHECK((world.rigid_bodies[0].angular_velocity_rad_s - spin_rad_s).norm() > 1.0);
  }
}

TEST_CASE("A pendulum of a stiff link swings back to where it was let go", "[sundials]") {
  const auto lost_share = [&](double tolerance_m_s) {
    Simulation simulation(integrated(
        sim_server::scene_of({sim_server::thread(2, {0, 0, 0}, {1, 0, 0}, 0.1, 1000.0, {0})}, {},
                             {0, 0, -9.81}),
        tolerance_m_s));
    const double energy_J = bodies::mechanical_energy_J(simulation.world());
    REQUIRE(advance(simulation, 0.01, 100));
    return std::abs(bodies::mechanical_energy_J(simulation.world()) - energy_J) / (0.1 * 9.81);
  };
  const double coarse = lost_share(1e-4), fine = lost_share(1e-8);

  CHECK(coarse < 0.1);
  CHECK(fine < 1e-5);
}

struct Bounce {
  double speed_m_s = 0.0, depth_m = 0.0;
};

/// A ball of 0.1 kg that meets a floor of 1000 N/m at 1 m/s, until it is off again.
Bounce bounce(double damping_N_s_per_m, double gravity_m_s2, double tolerance_m_s) {
  constexpr double kRadius_m = 0.05;
  Simulation simulation(integrated(
      sim_server::scene_of(
          {sim_server::moving(sim_server::sphere({0, 0, kRadius_m}, kRadius_m, 0.1), {0, 0, -1}),
           sim_server::floor_at(0.0)},
          sim_server::material_of(1000.0, damping_N_s_per_m), {0, 0, -gravity_m_s2}),
      tolerance_m_s));
  const bodies::RigidBody& ball = simulation.world().rigid_bodies[0];
  Bounce result;
  for (int step = 0; step < 1000; ++step) {
    REQUIRE(simulation.step(1e-4, no_tool).solve.converged);
    result.depth_m = std::max(result.depth_m, kRadius_m - ball.position_m.z());
    if (ball.position_m.z() > kRadius_m) break;
  }
  // When it left the floor.
  const double speed_m_s = ball.velocity_m_s.z();
  result.speed_m_s =
      std::sqrt(speed_m_s * speed_m_s + 2.0 * gravity_m_s2 * (ball.position_m.z() - kRadius_m));
  return result;
}

TEST_CASE("A ball bounces by the law of the approach damper, whose rate is its speed",
          "[sundials]") {
  for (const auto& [zeta, expected] : {std::pair(0.2, 0.756135), std::pair(0.5, 0.546293)}) {
    const double damping_N_s_per_m = 2.0 * zeta * std::sqrt(1000.0 * 0.1);
    const double restitution = bounce(damping_N_s_per_m, 0.0, 1e-7).speed_m_s;
    CHECK(std::abs(restitution - expected) < 1e-4);
  }
  // Its greatest depth is sampled each 0.1 ms: g / 8 * 1e-8 below, and then some.
  const Bounce undamped = bounce(0.0, 9.81, 1e-7);
  CHECK(std::abs(undamped.depth_m - 0.0110290) < 2e-7);
  CHECK(std::abs(undamped.speed_m_s - 1.0) < 1e-4);
}

/// A damped thread that swings down from level, and a spinning ball thrown flat on a smooth floor.
scene::SceneDescription swing_and_throw() {
  bodies::BodyDescription body = sim_server::thread(4, {0, 1, 1}, {0.3, 1, 1}, 0.01, 200.0, {0});
  sim_server::springs(body).spring_damping_N_s_per_m = 0.2;
  const bodies::BodyDescription ball = sim_server::moving(
      sim_server::sphere({0, 0, 0.055}, 0.05, 0.1), {0.5, 0.2, -0.3}, {0.0, 0.0, 3.0});
  return sim_server::scene_of({body, ball, sim_server::floor_at(0.0)},
                              sim_server::material_of(1000.0, 2.0), {0, 0, -9.81});
}

/// Where all that is free is after 0.15 s, and how the ball turns.
Eigen::Matrix3Xd end_of(const scene::SceneDescription& scene, double step_s) {
  Simulation simulation(scene);
  int touching = 0;
  for (long step = 0; step < std::lround(0.15 / step_s); ++step) {
    const StepReport report = simulation.step(step_s, no_tool);
    CHECK(report.solve.converged);
    touching = std::max(touching, report.contacts);
  }
  CHECK(touching == 1);
  const auto& nodes = simulation.world().nodes;
  const bodies::RigidBody& ball = simulation.world().rigid_bodies[0];
  Eigen::Matrix3Xd end(3, 5);
  for (Eigen::Index i = 1; i < 4; ++i)
    end.col(i - 1) = nodes[static_cast<std::size_t>(i)].position_m;
  end.col(3) = ball.position_m;
  end.col(4) = 0.05 * ball.angular_velocity_rad_s;
  return end;
}

TEST_CASE("SUNDIALS goes where implicit Euler goes by tiny steps", "[sundials]") {
  const Eigen::Matrix3Xd accurate = end_of(integrated(swing_and_throw(), 1e-7), 0.01);
  const Eigen::Matrix3Xd coarse = end_of(swing_and_throw(), 1e-4);
  const Eigen::Matrix3Xd fine = end_of(swing_and_throw(), 5e-5);

  // Euler's error is of first order: from two steps follows the limit.
  const double error = (fine - accurate).cwiseAbs().maxCoeff();
  const double limit_error = (2.0 * fine - coarse - accurate).cwiseAbs().maxCoeff();
  INFO("errors " << error << ", of the limit " << limit_error);
  CHECK(error < 2e-3);
  CHECK(limit_error < 0.3 * error);
}

TEST_CASE("A tick by CVODE depends on its start alone: a copy goes on to the bit", "[sundials]") {
  scene::SceneDescription scene = swing_and_throw();
  scene.materials.at(0).friction = 0.3;
  scene = integrated(scene, 1e-5);
  Simulation first(scene);
  REQUIRE(advance(first, 0.01, 8));
  REQUIRE(first.world().rigid_bodies[0].angular_velocity_rad_s.x() != 0.0);  // friction acts

  Simulation second(scene, first.world());
  second.set_contact_state(first.contact_state());
  REQUIRE(advance(first, 0.01, 8));
  REQUIRE(advance(second, 0.01, 8));

  for (std::size_t i = 0; i < first.world().nodes.size(); ++i)
    CHECK(first.world().nodes[i].position_m == second.world().nodes[i].position_m);
  const auto &a = first.world().rigid_bodies[0], &b = second.world().rigid_bodies[0];
  CHECK(a.position_m == b.position_m);
  CHECK(a.angular_velocity_rad_s == b.angular_velocity_rad_s);
}

TEST_CASE("CVODE accounts for energy: a tool that pushes a damped ball over a rough floor",
          "[sundials]") {
  scene::SceneDescription scene = sim_server::scene_of(
      {sim_server::sphere({0, 0, 0.0195}, 0.02, 0.1), sim_server::floor_at(0.0)},
      sim_server::material_of(1000.0, 2.0, 0.3), {0, 0, -9.81});
  scene.tool = {{Eigen::Vector3d::Zero(), 0.01}};
  Simulation simulation(integrated(scene, 1e-7));
  simulation.account_energy();
  std::uint64_t time_ns = 0;
  for (int step = 1; step <= 40; ++step) {
    time_ns += 10'000'000;
    REQUIRE(simulation
                .step(0.01,
                      [&] {
                        return ToolSample{.time_ns = time_ns,
                                          .position_m = {-0.032 + 0.002 * step, 0, 0.02},
                                          .velocity_m_s = {0.2, 0, 0}};
                      })
                .solve.converged);
  }
  const EnergyAccount account = *simulation.energy_account();
  REQUIRE(simulation.world().rigid_bodies[0].position_m.x() > 0.03);
  CHECK(account.flow.given_J > 1e-3);
  CHECK(account.flow.tool_J[0] == Approx(account.flow.given_J).epsilon(1e-4));
  CHECK(account.flow.contact_damping_J > 0.0);
  CHECK(account.flow.friction_J > 0.0);
  CHECK(std::abs(account.numerical_J()) < 1e-3 * account.flow.given_J);
}

TEST_CASE("A state that is not finite is told", "[sundials]") {
  Simulation simulation(integrated(swing_and_throw(), 1e-6));
  simulation.world().nodes.back().velocity_m_s.z() = std::numeric_limits<double>::quiet_NaN();

  CHECK_THROWS_AS(simulation.step(0.01, no_tool), std::domain_error);
}

TEST_CASE("A tick that takes too much work ends the run, and the world stays where it was",
          "[sundials]") {
  Simulation simulation(integrated(
      sim_server::scene_of({sim_server::moving(sim_server::sphere({0, 0, 0.0199}, 0.02, 0.05),
                                               {0, 0, 0}, {0, 0, 1e6}),
                            sim_server::floor_at(0.0)},
                           sim_server::material_of(1000.0, 1.0, 0.6), {0, 0, -9.81}),
      1e-4));
  const bodies::RigidBody& ball = simulation.world().rigid_bodies[0];
  const Eigen::Vector3d before_m = ball.position_m;

  CHECK_THROWS_WITH(simulation.step(0.01, no_tool),
                    Catch::Contains("cvode_bdf takes more than 20000 steps and products"));
  CHECK(ball.position_m == before_m);
  CHECK(simulation.world().time_s == 0.0);
}

TEST_CASE("What no force acts on goes straight on, and what rests stays", "[sundials]") {
  const double speed_m_s = GENERATE(0.3, 0.0);
  CAPTURE(speed_m_s);
  // Alone: with anything else in the world forces would be small, not none.
  Simulation simulation(integrated(
      sim_server::scene_of({sim_server::moving(sim_server::sphere({0, 0, 0}, 0.01, 0.1),
                                               {speed_m_s, 0, 0}, {0, 0, 10.0 * speed_m_s})}),
      1e-6));

  for (int i = 0; i < 100; ++i) REQUIRE(simulation.step(0.01, no_tool).solve.converged);

  const bodies::RigidBody& ball = simulation.world().rigid_bodies[0];
  CHECK((ball.position_m - Eigen::Vector3d(speed_m_s, 0, 0)).norm() < 1e-8);
  CHECK((ball.angular_velocity_rad_s - Eigen::Vector3d(0, 0, 10.0 * speed_m_s)).norm() < 1e-8);
}

TEST_CASE("Nothing free is nothing to integrate", "[sundials]") {
  Simulation simulation(integrated(sim_server::scene_of({sim_server::floor_at(0.0)}), 1e-6));
  CHECK(simulation.step(0.01, no_tool).solve.converged);
}

}  // namespace
}  // namespace stillgrid::dynamics::sundials_integrator_test
