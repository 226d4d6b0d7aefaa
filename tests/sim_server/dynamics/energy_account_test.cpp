#include "sim_server/dynamics/step/energy_account.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::energy_account_test {
namespace {

/// A mass of 0.1 kg on a spring of 1000 N/m, 4 mm out.
Simulation oscillator(double damping_N_s_per_m) {
  bodies::BodyDescription body = sim_server::thread(2, {0, 0, 0}, {0.1, 0, 0}, 0.1, 1000.0, {0});
  sim_server::springs(body).spring_damping_N_s_per_m = damping_N_s_per_m;
  Simulation simulation(sim_server::scene_of({body}));
  simulation.world().nodes[1].position_m.x() = 0.104;
  simulation.account_energy();
  return simulation;
}

TEST_CASE("Without losses what is missing is what implicit Euler lost", "[energy]") {
  const double step_s = GENERATE(0.001, 0.01);
  Simulation simulation = oscillator(0.0);

  REQUIRE(advance(simulation, step_s, 10));

  const EnergyAccount account = *simulation.energy_account();
  CHECK(account.start.total_J() == Approx(0.5 * 1000.0 * 0.004 * 0.004));
  const double left = std::pow(1.0 + 1e4 * step_s * step_s, -10);
  CHECK(account.numerical_J() == Approx(account.start.total_J() * (1.0 - left)).epsilon(1e-9));
  CHECK(account.end.total_J() ==
        Approx(bodies::mechanical_energy_J(simulation.world())).epsilon(1e-12));
}

TEST_CASE("A spring's damper takes all that an oscillator loses, as the step shrinks", "[energy]") {
  const auto run = [](double step_s) {
    Simulation simulation = oscillator(2.0);
    REQUIRE(advance(simulation, step_s, static_cast<int>(std::lround(0.1 / step_s))));
    return *simulation.energy_account();
  };
  const EnergyAccount coarse = run(2e-4), fine = run(1e-4);

  CHECK(coarse.numerical_J() / fine.numerical_J() == Approx(2.0).epsilon(0.05));
  const auto unexplained_J = [](const EnergyAccount& account) {
    return account.start.total_J() - account.end.total_J() - account.flow.spring_damping_J;
  };
  CHECK(std::abs(2.0 * unexplained_J(fine) - unexplained_J(coarse)) <
        5e-3 * fine.flow.spring_damping_J);
  CHECK(fine.end.total_J() < 0.3 * fine.start.total_J());
  CHECK(fine.flow.friction_J == 0.0);
  CHECK(fine.flow.contact_damping_J == 0.0);
}

TEST_CASE("Where contacts' geometry is linear the account closes to rounding in every step",
          "[energy]") {
  // Balls that fall on a slope, bounce, slide, roll and come to rest against a wall.
  scene::SceneDescription scene = sim_server::scene_of(
      {sim_server::moving(sim_server::sphere({-0.3, 0, 0.03}, 0.01, 0.02), {0.4, 0.1, -0.5},
                          {0, 0, 40}),
       sim_server::moving(sim_server::sphere({-0.25, 0.1, 0.02}, 0.015, 0.07), {-0.2, 0, 0.1}),
       sim_server::floor_at(0.0)},
      sim_server::material_of(2000.0, GENERATE(0.0, 1.5), 0.3), {1.1, 0, -9.7});
  scene.method.integrator = scene::IntegratorKind::kVelocityVerlet;
  Simulation simulation(scene);
  simulation.account_energy();
  double start_J = simulation.energy_account()->start.total_J(), worst_J = 0.0, before_J = 0.0;
  for (int i = 0; i < 400; ++i) {
    REQUIRE(advance(simulation, 0.0071, 1));
    const EnergyAccount account = *simulation.energy_account();
    const double left_J = account.numerical_J() + account.flow.unsolved_J;
    worst_J = std::max(worst_J, std::abs(left_J - before_J));
    before_J = left_J;
  }
  const EnergyAccount account = *simulation.energy_account();
  CHECK(account.flow.friction_J > 1e-3);
  CHECK(worst_J < 5e-6 * (std::abs(start_J) + account.flow.friction_J));
}

TEST_CASE("Friction takes mu m g d from a sliding block", "[energy]") {
  // Four spheres of 5000 N/m carry it from the start.
  const double sunk_m = 0.1 * 9.81 / (4 * 5000.0);
  Simulation simulation(sim_server::scene_of(
      {sim_server::moving(
           sim_server::box({0, 0, 0.005 - sunk_m}, {0.06, 0.06, 0.01}, 0.1, {0.05, 0.005}),
           {1.0, 0, 0}),
       sim_server::floor_at(0.0)},
      sim_server::material_of(5000.0, 0.0, 0.3), {0, 0, -9.81}));
  simulation.account_energy();

  REQUIRE(advance(simulation, 1e-4, 2000));

  const bodies::RigidBody& block = simulation.world().rigid_bodies[0];
  const EnergyAccount account = *simulation.energy_account();
  REQUIRE(block.velocity_m_s.x() > 0.2);
  CHECK(account.flow.friction_J == Approx(0.3 * 0.1 * 9.81 * block.position_m.x()).epsilon(2e-3));
  CHECK(account.flow.given_J == 0.0);
  CHECK(std::abs(account.numerical_J()) < 1e-3 * account.flow.friction_J);
}

TEST_CASE("The approach damper takes what a bounce does not restore", "[energy]") {
  // zeta = 0.2: restitution exp(-(z/q) acos z) = 0.756135
  constexpr double kStiffness_N_per_m = 1000.0, kMass_kg = 0.1;
  const double damping_N_s_per_m = 0.4 * std::sqrt(kStiffness_N_per_m * kMass_kg);
  Simulation simulation(sim_server::scene_of(
      {sim_server::moving(sim_server::sphere({0, 0, 0.05}, 0.05, kMass_kg), {0, 0, -1.0}),
       sim_server::floor_at(0.0)},
      sim_server::material_of(kStiffness_N_per_m, damping_N_s_per_m)));
  simulation.account_energy();

  REQUIRE(advance(simulation, 1e-5, 6000));

  const EnergyAccount account = *simulation.energy_account();
  REQUIRE(account.end.contacts_J == 0.0);  // it has left
  CHECK(account.flow.contact_damping_J ==
        Approx(0.5 * kMass_kg * (1.0 - 0.756135 * 0.756135)).epsilon(2e-3));
  CHECK(std::abs(account.numerical_J()) < 5e-3 * account.start.total_J());
}

TEST_CASE("What the tool or a prescribed body gives is its force times its way", "[energy]") {
  // 0.2 m/s against a ball that lies 2 mm before it.
  constexpr double kStep_s = 1e-4, kSpeed_m_s = 0.2, kMass_kg = 0.1;
  const bool by_tool = GENERATE(true, false);
  bodies::BodyDescription pusher = sim_server::sphere({-0.0205, 0, 0}, 0.01, 0.0);
  pusher.motion = bodies::Motion::kPrescribed;
  pusher.prescribed = {.velocity_m_s = kSpeed_m_s * Eigen::Vector3d::UnitX()};
  const bodies::BodyDescription ball = sim_server::sphere({0, 0, 0}, 0.01, kMass_kg);
  scene::SceneDescription scene =
      by_tool ? sim_server::scene_of({ball}, sim_server::material_of(100.0, 1.0))
              : sim_server::scene_of({pusher, ball}, sim_server::material_of(100.0, 1.0));
  scene.tool = {{Eigen::Vector3d::Zero(), 0.01}};
  Simulation simulation(scene);
  simulation.account_energy();
  const bodies::RigidBody& pushed = simulation.world().rigid_bodies.back();

  double work_J = 0.0;
  for (int i = 1; i <= 2000; ++i) {
    const double before_m_s = pushed.velocity_m_s.x();
    const ToolSample tool{.position_m = {-0.0205 + kSpeed_m_s * kStep_s * i, 0, 0},
                          .velocity_m_s = {kSpeed_m_s, 0, 0}};
    const StepReport report =
        simulation.step(kStep_s, [&] { return by_tool ? std::optional(tool) : std::nullopt; });
    REQUIRE(report.solve.converged);
    work_J += kMass_kg * (pushed.velocity_m_s.x() - before_m_s) * kSpeed_m_s;
  }

  const EnergyAccount account = *simulation.energy_account();
  REQUIRE(pushed.velocity_m_s.x() > 0.1);
  CHECK(account.flow.given_J == Approx(work_J).epsilon(1e-6));
  CHECK(account.start.total_J() == 0.0);
  // The damper takes some; little else is left.
  CHECK(account.flow.contact_damping_J > 0.0);
  CHECK(std::abs(account.numerical_J()) < 0.01 * work_J);
}

TEST_CASE("A tool that comes and goes inside a body brings and takes the contact's energy",
          "[energy]") {
  constexpr double kStep_s = 1e-6, kDepth_m = 0.005;
  scene::SceneDescription scene = sim_server::scene_of({sim_server::sphere({0, 0, 0}, 0.01, 0.1)},
                                                       sim_server::material_of(100.0));
  scene.tool = {{Eigen::Vector3d::Zero(), 0.01}};
  scene.tool_slip_speed_m_s = scene::kPenaltySlip_m_s;
  Simulation simulation(scene);
  simulation.account_energy();
  const double held_J = 0.5 * 100.0 * kDepth_m * kDepth_m;

  (void)simulation.step(kStep_s, [] { return ToolSample{.position_m = {0, 0, 0.015}}; });
  const EnergyAccount come = *simulation.energy_account();
  (void)simulation.step(kStep_s, no_tool);
  const EnergyAccount gone = *simulation.energy_account();

  CHECK(come.flow.given_J == Approx(held_J).epsilon(1e-6));
  CHECK(come.end.contacts_J == Approx(held_J).epsilon(1e-6));
  CHECK(std::abs(gone.flow.given_J) < 1e-6 * held_J);
  CHECK(gone.end.contacts_J == 0.0);
}

TEST_CASE(
    "The tool's work is booked whether or not energy is accounted for, and is all that is given",
    "[energy]") {
  // A tool that stirs among balls and a thread, and is away for a while.
  const auto integrator =
      GENERATE(scene::IntegratorKind::kVelocityVerlet, scene::IntegratorKind::kImplicitEuler);
  scene::SceneDescription scene = sim_server::scene_of(
      {sim_server::floor_at(-0.02), sim_server::sphere({0, 0, 0}, 0.01, 0.05),
       sim_server::sphere({0.021, 0.002, 0}, 0.01, 0.03),
       sim_server::thread(5, {-0.03, 0, 0.012}, {0.03, 0.004, 0.012}, 0.02, 90.0, {0})},
      sim_server::material_of(700.0, 0.8, 0.3), {0, 0, -9.81});
  scene.tool = {{Eigen::Vector3d::Zero(), 0.006}, {{0.009, 0, 0}, 0.005}};
  scene.tool_slip_speed_m_s = scene::kPenaltySlip_m_s;
  scene.method.integrator = integrator;
  Simulation simulation(scene);
  simulation.account_energy();
  StepReport report;
  for (int i = 1; i <= 300; ++i) {
    const double t_s = 0.0037 * i;
    const ToolSample tool{.time_ns = static_cast<std::uint64_t>(1e9 * t_s),
                          .position_m = {0.017 * std::sin(9.1 * t_s), 0.004 * std::cos(5.3 * t_s),
                                         0.014 - 0.01 * std::sin(3.3 * t_s)},
                          .velocity_m_s = {0.155 * std::cos(9.1 * t_s), 0, 0}};
    report =
        simulation.step(0.0037, [&] { return i % 90 > 80 ? std::nullopt : std::optional(tool); });
  }
  const EnergyAccount account = *simulation.energy_account();
  INFO(scene::name_of(integrator));
  REQUIRE(std::abs(report.tools[0].work_J) > 1e-4);
  CHECK(report.tools[0].work_J == Approx(account.flow.given_J).epsilon(1e-9));
}

/// What is left of the account of a tool that stays in contact with a ball on a spring, neither
/// damped, after 0.4 s; as a share of what the tool gave at most.
double numerical_share(const scene::IntegratorKind& integrator, double step_s) {
  scene::SceneDescription scene =
      sim_server::scene_of({sim_server::thread(2, {-0.1, 0, 0}, {0, 0, 0}, 0.1, 5000.0, {0})},
                           sim_server::material_of(700.0));
  scene.tool = {{Eigen::Vector3d::Zero(), 0.01}};
  scene.tool_slip_speed_m_s = scene::kPenaltySlip_m_s;
  scene.method.integrator = integrator;
  Simulation simulation(scene);
  simulation.account_energy();
  StepReport report;
  double most_J = 0.0;
  const int steps = static_cast<int>(std::lround(0.4 / step_s));
  for (int i = 1; i <= steps; ++i) {
    const double x_m = 0.013 - 0.003 * std::sin(40.0 * step_s * i);
    report = simulation.step(step_s, [&] { return ToolSample{.position_m = {x_m, 0, 0}}; });
    REQUIRE(report.contacts == 1);
    most_J = std::max(most_J, std::abs(report.tools[0].work_J));
  }
  const EnergyAccount account = *simulation.energy_account();
  REQUIRE(account.flow.given_J == Approx(report.tools[0].work_J));
  return account.numerical_J() / most_J;
}

TEST_CASE("What the tool gives to what keeps energy is what that gains, to the method's order",
          "[energy]") {
  const double coarse = numerical_share(scene::IntegratorKind::kVelocityVerlet, 2e-4);
  const double fine = numerical_share(scene::IntegratorKind::kVelocityVerlet, 1e-4);
  CHECK(std::abs(coarse) > 3.0 * std::abs(fine));  // second order
}

TEST_CASE("What the tool gives to what is prescribed is force times way, and none of the world's",
          "[energy]") {
  // Between a ball that comes on at a steady speed and a tool that comes to meet it and goes.
  constexpr double kStiffness_N_per_m = 430.0, kSpeed_m_s = 0.031, kStep_s = 0.0071;
  bodies::BodyDescription pusher = sim_server::sphere({0, 0, 0}, 0.011, 0.0);
  pusher.motion = bodies::Motion::kPrescribed;
  pusher.prescribed = {.velocity_m_s = kSpeed_m_s * Eigen::Vector3d::UnitZ()};
  scene::SceneDescription scene =
      sim_server::scene_of({pusher}, sim_server::material_of(kStiffness_N_per_m));
  scene.tool = {{Eigen::Vector3d::Zero(), 0.006}};
  scene.method.integrator =
      GENERATE(scene::IntegratorKind::kVelocityVerlet, scene::IntegratorKind::kImplicitEuler);
  Simulation simulation(scene);
  simulation.account_energy();
  const auto height_m = [](double t_s) { return 0.025 - 0.012 * std::sin(11.0 * t_s); };
  StepReport report;
  for (int i = 1; i <= 41; ++i)
    report = simulation.step(kStep_s, [&] {
      return ToolSample{.position_m = {0, 0, height_m(kStep_s * i)}};
    });
  double work_J = 0.0;  // the integral, by a step a thousand times finer
  for (int i = 1; i <= 41'000; ++i) {
    const double start_s = 1e-3 * kStep_s * (i - 1), end_s = 1e-3 * kStep_s * i;
    const double middle_s = 0.5 * (start_s + end_s);
    const double depth_m = 0.017 - (height_m(middle_s) - kSpeed_m_s * middle_s);
    work_J -= kStiffness_N_per_m * std::max(0.0, depth_m) * (height_m(end_s) - height_m(start_s));
  }
  REQUIRE(std::abs(work_J) > 1e-3);
  CHECK(report.tools[0].work_J == Approx(work_J).epsilon(0.02));
  CHECK(simulation.energy_account()->flow.given_J == 0.0);
}

/// Two spinning boxes that graze each other, with dampers and friction.
scene::SceneDescription collision() {
  const Eigen::Vector3d size_m(0.03, 0.03, 0.02);
  return sim_server::scene_of(
      {sim_server::moving(sim_server::box({0, 0, 0}, size_m, 0.02, {0.01, 0.005}), {0, 0, 0.3},
                          {2, 5, 1}),
       sim_server::moving(sim_server::box({0.012, 0.008, 0.035}, size_m, 0.03, {0.01, 0.005}),
                          {0.1, 0, -0.3}, {-4, 3, 7})},
      sim_server::material_of(500.0, 0.5, 0.4, 0.05));
}

/// What a run of the collision came to, and what share of its angular momentum it lost.
struct CollisionRun {
  EnergyAccount account;
  double angular_lost;
};

CollisionRun run_collision(double step_s, scene::IntegratorKind integrator) {
  scene::SceneDescription scene = collision();
  scene.method.integrator = integrator;
  Simulation simulation(scene);
  simulation.account_energy();
  const Eigen::Vector3d momentum = momentum_kg_m_per_s(simulation.world());
  const Eigen::Vector3d angular = angular_momentum_kg_m2_per_s(simulation.world());
  CHECK((momentum - Eigen::Vector3d(0.003, 0, -0.003)).norm() < 1e-15);
  REQUIRE(advance(simulation, step_s, static_cast<int>(std::lround(0.1 / step_s))));
  CHECK((momentum_kg_m_per_s(simulation.world()) - momentum).norm() <
        1e-8);  // of floats, or of the solver's tolerance
  return {*simulation.energy_account(),
          (angular_momentum_kg_m2_per_s(simulation.world()) - angular).norm() / angular.norm()};
}

TEST_CASE("A collision keeps momentum, and its energy is accounted for", "[energy]") {
  const auto [coarse, coarse_lost] = run_collision(2e-4, scene::IntegratorKind::kImplicitEuler);
  const auto [fine, fine_lost] = run_collision(1e-4, scene::IntegratorKind::kImplicitEuler);

  CHECK(fine.flow.friction_J > 1e-5);
  CHECK(fine.flow.contact_damping_J > 1e-5);
  CHECK(coarse.numerical_J() / fine.numerical_J() == Approx(2.0).epsilon(0.15));
  CHECK(fine_lost < 1e-3);
  CHECK(coarse_lost / fine_lost == Approx(2.0).epsilon(0.1));  // of first order
}

TEST_CASE("An explicit collision keeps angular momentum to rounding of floats", "[energy]") {
  const auto [account, lost] = run_collision(1e-4, scene::IntegratorKind::kVelocityVerlet);
  CHECK(account.flow.friction_J > 1e-5);
  CHECK(lost < 1e-6);
}

TEST_CASE("What sleeps keeps its energy but for the kinetic, which is counted", "[energy]") {
  scene::SceneDescription scene = sim_server::scene_of(
      {sim_server::box({0, 0, 0.0145}, Eigen::Vector3d::Constant(0.03), 0.1, {0.02, 0.005}),
       sim_server::floor_at(0.0)},
      sim_server::material_of(1250.0, 2.0, 0.5), {0, 0, -9.81});
  scene.sleeping = true;
  Simulation simulation(scene);
  simulation.account_energy();
  EnergyAccount awake;
  for (int i = 0; i < 1000 && !simulation.world().bodies[0].is_sleeping; ++i) {
    awake = *simulation.energy_account();
    (void)simulation.step(0.01, no_tool);
  }
  REQUIRE(simulation.world().bodies[0].is_sleeping);

  const EnergyAccount is_sleeping = *simulation.energy_account();

  // m g (m g / 2 k) on four spheres
  CHECK(is_sleeping.end.contacts_J == Approx(0.981 * 0.981 / (2.0 * 5000.0)).epsilon(1e-3));
  CHECK(is_sleeping.end.kinetic_J == 0.0);
  CHECK(is_sleeping.sleep_loss_J > 0.0);
  CHECK(is_sleeping.sleep_loss_J < 0.5 * 0.1 * 0.15e-3 * 0.15e-3);
  CHECK(is_sleeping.numerical_J() == Approx(awake.numerical_J()).epsilon(1e-6));
}

TEST_CASE("Accounting changes no step", "[energy]") {
  Simulation one(collision()), other(collision());
  one.account_energy();
  for (int i = 0; i < 100; ++i) {
    REQUIRE(advance(one, 1e-3, 1));
    REQUIRE(advance(other, 1e-3, 1));
  }

  CHECK_FALSE(other.energy_account());
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(one.world().rigid_bodies[i].position_m == other.world().rigid_bodies[i].position_m);
    CHECK(one.world().rigid_bodies[i].orientation.coeffs() ==
          other.world().rigid_bodies[i].orientation.coeffs());
  }
}

}  // namespace
}  // namespace stillgrid::dynamics::energy_account_test
