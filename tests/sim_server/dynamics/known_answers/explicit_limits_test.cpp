// Where explicit methods hold and where they fail, as docs/cases.md, section 3, has it.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/sim_server/dynamics/known_answers/oscillator.hpp"
#include "tests/sim_server/dynamics/known_answers/slope.hpp"

namespace stillgrid::dynamics::explicit_limits_test {
namespace {

constexpr auto kVerlet = scene::IntegratorKind::kVelocityVerlet;

scene::Method verlet(int substeps) {
  return {.integrator = kVerlet, .substeps = substeps};
}

TEST_CASE("Verlet holds below (2 / w) (sqrt(1 + zeta^2) - zeta) and not above",
          "[explicit_limits]") {
  const auto [damping_ratio, known_s] = GENERATE(std::pair(0.0, 0.0200), std::pair(0.05, 0.01902),
                                                 std::pair(0.2, 0.01640), std::pair(0.5, 0.01236));
  const double limit_s =
      2.0 / kRate_rad_s * (std::sqrt(1.0 + damping_ratio * damping_ratio) - damping_ratio);
  CHECK(std::abs(limit_s - known_s) < 5e-6);
  // Near its limit a stable run's energy swings by 1 / (1 - (wh/2)^2) = 50.
  CHECK(energy_growth(damping_ratio, kVerlet, 0.99 * limit_s, 500, 1) < 60.0);
  CHECK(energy_growth(damping_ratio, kVerlet, 1.01 * limit_s, 500, 1) > 1e4);

  // Left to choose, it stays below: not a joule more than there was, if damped.
  Simulation simulation(oscillator(damping_ratio, verlet(0)));
  pull(simulation);
  const double before_J = bodies::mechanical_energy_J(simulation.world());
  constexpr double kStep_s = 0.05;
  int substeps = 0;
  for (int i = 0; i < 100; ++i) substeps = simulation.step(kStep_s, no_tool).substeps;
  CHECK(kStep_s / substeps < limit_s);
  CHECK(bodies::mechanical_energy_J(simulation.world()) < 12.0 * before_J);
}

/// Ten masses of 10 g on springs of 100 N/m hang from a wall, pulled evenly; the exact motion is a
/// sum of modes.
double chain_error_m(double step_s) {
  constexpr int kMasses = 10;
  const double stiffness_N_per_m = 100.0, mass_kg = 0.01, pull_m = 0.001;
  scene::SceneDescription scene = sim_server::scene_of(
      {sim_server::thread(kMasses + 1, {0, 0, 0}, {1, 0, 0}, mass_kg, stiffness_N_per_m, {0})});
  scene.method = verlet(1);
  scene.sleeping = false;
  Simulation simulation(scene);
  bodies::World& world = simulation.world();
  Eigen::VectorXd start_m(kMasses);
  for (int i = 0; i < kMasses; ++i) {
    start_m[i] = pull_m * (i + 1);
    world.nodes[static_cast<std::size_t>(i) + 1].position_m.x() += start_m[i];
  }
  const bodies::World rest = scene::build_world(scene);
  Eigen::MatrixXd chain = 2.0 * Eigen::MatrixXd::Identity(kMasses, kMasses);
  chain(kMasses - 1, kMasses - 1) = 1.0;
  for (int i = 0; i + 1 < kMasses; ++i) chain(i, i + 1) = chain(i + 1, i) = -1.0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(stiffness_N_per_m / mass_kg * chain);
  const Eigen::VectorXd amplitude = modes.eigenvectors().transpose() * start_m;
  const Eigen::ArrayXd rates = modes.eigenvalues().array().sqrt();
  double worst_m = 0.0;
  for (double t_s = step_s; t_s < 0.5 + 0.5 * step_s && worst_m < 1e9; t_s += step_s) {
    (void)advance(simulation, step_s, 1);
    const Eigen::VectorXd exact_m =
        modes.eigenvectors() * (amplitude.array() * (rates * t_s).cos()).matrix();
    for (int i = 0; i < kMasses; ++i) {
      const auto node = static_cast<std::size_t>(i) + 1;
      worst_m = std::max(worst_m, std::abs(world.nodes[node].position_m.x() -
                                           rest.nodes[node].position_m.x() - exact_m[i]));
    }
  }
  return worst_m;
}

TEST_CASE("Verlet's error falls as its step's square, and past 10.11 ms it fails",
          "[explicit_limits]") {
  CHECK(std::log2(chain_error_m(5e-4) / chain_error_m(2.5e-4)) == Approx(2.0).margin(0.005));
  CHECK(chain_error_m(10.0e-3) < 0.1);
  CHECK(chain_error_m(10.3e-3) > chain_error_m(10.0e-3));
  CHECK(chain_error_m(20e-3) > 1e6);
}

/// Least and greatest speed, over the phase, of an undamped ball of 100 rad/s thrown at the floor
/// at 1 m/s.
std::pair<double, double> restitutions(double step_s, int substeps) {
  constexpr double kRadius_m = 0.05;
  double least = 10.0, greatest = 0.0;
  constexpr int kPhases = 40;
  for (int i = 0; i < kPhases; ++i) {
    const double gap_m = 0.1 + 1.0 * step_s * i / kPhases;
    scene::SceneDescription scene = sim_server::scene_of(
        {sim_server::moving(sim_server::sphere({0, 0, kRadius_m + gap_m}, kRadius_m, 0.1),
                            {0, 0, -1}),
         sim_server::floor_at(0.0)},
        sim_server::material_of(1000.0));
    scene.method = verlet(substeps);
    Simulation simulation(scene);
    const bodies::RigidBody& ball = simulation.world().rigid_bodies[0];
    while (ball.velocity_m_s.z() <= 0.0 || ball.position_m.z() < kRadius_m)
      REQUIRE(advance(simulation, step_s, 1));
    least = std::min(least, ball.velocity_m_s.z());
    greatest = std::max(greatest, ball.velocity_m_s.z());
  }
  return {least, greatest};
}

TEST_CASE("An undamped bounce keeps its speed, however few substeps it takes",
          "[explicit_limits]") {
  // Iterations end where 3 % of a substep's change of velocity are left.
  const double phase = GENERATE(0.3, 0.5, 1.5);
  const auto [least, most] = restitutions(phase / kRate_rad_s, 1);
  CHECK(least > 0.97);
  CHECK(most < 1.03);
}

TEST_CASE("Left to choose its substeps it keeps a bounce's speed to 1 %", "[explicit_limits]") {
  const double step_s = GENERATE(0.003, 0.015, 0.03);
  const auto [least, most] = restitutions(step_s, 0);
  CHECK(least > 0.99);
  CHECK(most < 1.01);
}

TEST_CASE("Left to choose its substeps an undamped ball bounces on for seconds",
          "[explicit_limits]") {
  // Substeps are longer in flight than in contact.
  const double step_s = 1.0 / GENERATE(33.7, 361.3);
  scene::SceneDescription scene = sim_server::scene_of(
      {sim_server::sphere({0, 0, 0.0437}, 0.0131, 0.0118), sim_server::floor_at(0.0)},
      sim_server::material_of(3388.0), {0, 0, -9.81});
  scene.method = verlet(0);
  Simulation simulation(scene);
  simulation.account_energy();
  const double above_J = 0.0118 * 9.81 * (0.0437 - 0.0131);
  for (double time_s = 0.0; time_s < 3.0; time_s += step_s) REQUIRE(advance(simulation, step_s, 1));
  CHECK(std::abs(simulation.energy_account()->numerical_J()) < 0.1 * above_J);
}

TEST_CASE("Two balls exchange velocities, momentum and time as in a perfect collision",
          "[explicit_limits]") {
  constexpr double kRadius_m = 0.05, kStep_s = 2e-4;
  scene::SceneDescription scene = sim_server::scene_of(
      {sim_server::moving(sim_server::sphere({0, 0, 0}, kRadius_m, 0.1), {1, 0, 0}),
       sim_server::moving(sim_server::sphere({0.1001, 0, 0}, kRadius_m, 0.3), {-0.2, 0, 0})},
      sim_server::material_of(1000.0));
  scene.method = verlet(1);
  Simulation simulation(scene);
  const bodies::RigidBody& a = simulation.world().rigid_bodies[0];
  const bodies::RigidBody& b = simulation.world().rigid_bodies[1];
  double time_s = 0.0, depth_m = 0.0, momentum_drift_N_s = 0.0;
  for (int i = 0; i < 250; ++i) {
    time_s += simulation.step(kStep_s, no_tool).contacts > 0 ? kStep_s : 0.0;
    depth_m = std::max(depth_m, 2.0 * kRadius_m - (b.position_m - a.position_m).norm());
    momentum_drift_N_s = std::max(
        momentum_drift_N_s, std::abs(0.1 * a.velocity_m_s.x() + 0.3 * b.velocity_m_s.x() - 0.04));
  }
  CHECK(a.velocity_m_s.x() == Approx(-0.8).margin(2e-3));
  CHECK(b.velocity_m_s.x() == Approx(0.4).margin(1e-3));
  CHECK(time_s == Approx(0.027207).margin(2.0 * kStep_s));
  CHECK(depth_m == Approx(0.0103923).margin(1e-5));
  CHECK(momentum_drift_N_s < 1e-6 * 0.4);  // floats
}

Slide slide_on(double angle_deg, const scene::Method& method) {
  return dynamics::slide_on(angle_deg, method, 1000, 1000);
}

TEST_CASE("A block slips on a slope if tan of its angle exceeds the friction, and only then",
          "[explicit_limits]") {
  const scene::Method method = verlet(GENERATE(0, 10));
  CAPTURE(scene::describe(method));
  const Slide below = slide_on(16.0, method), above = slide_on(17.4, method);
  CHECK(std::abs(below.velocity_m_s) < 1e-6);
  CHECK(std::abs(below.acceleration_m_s2) < 1e-5);
  CHECK(above.velocity_m_s > 0.05);
  CHECK(above.acceleration_m_s2 == Approx(9.81 * (std::sin(17.4 * std::numbers::pi / 180.0) -
                                                  0.3 * std::cos(17.4 * std::numbers::pi / 180.0)))
                                       .margin(1e-4));
  CHECK(slide_on(30.0, method).acceleration_m_s2 == Approx(2.35629).margin(1e-4));
}

TEST_CASE("Below the friction angle nothing creeps, whatever the substep and the slip speed",
          "[explicit_limits]") {
  const Slide slide = slide_on(10.0, verlet(GENERATE(1, 40)));
  CHECK(std::abs(slide.velocity_m_s) < 10e-6 / 60.0);
}

}  // namespace
}  // namespace stillgrid::dynamics::explicit_limits_test
