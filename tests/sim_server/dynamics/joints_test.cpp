// What joints keep: momentum, energy, a stretch, a period.
#include "sim_server/bodies/joints.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/sim_server/dynamics/joined.hpp"

namespace stillgrid::dynamics::joints_test {
namespace {

constexpr unsigned kSeeds = tests::kCut == 1 ? 12 : 3;

/// How much of a spin is lost or made within half a second, of what the bodies have between them.
double angular_error(unsigned seed, const scene::Method& method, double step_s) {
  scene::SceneDescription scene = drawn_chain(seed, 0.3, 0.0, false);
  scene.method = method;
  Simulation simulation(scene);
  const Eigen::Vector3d before = angular_momentum_kg_m2_per_s(simulation.world());
  REQUIRE(advance(simulation, step_s, static_cast<int>(std::lround(0.5 / step_s))));
  return (angular_momentum_kg_m2_per_s(simulation.world()) - before).norm() / before.norm();
}

TEST_CASE("Joined free bodies keep their momentum, and by explicit methods their spin",
          "[joints]") {
  const scene::IntegratorKind kind = GENERATE(from_range(kBothIntegrators));
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    scene::SceneDescription scene = drawn_chain(seed, 0.3, 0.0, false);
    scene.method.integrator = kind;
    Simulation simulation(scene);
    const Eigen::Vector3d momentum = momentum_kg_m_per_s(simulation.world());
    const Eigen::Vector3d spin = angular_momentum_kg_m2_per_s(simulation.world());

    REQUIRE(advance(simulation, 0.005, 100));

    INFO(kind.name << ", seed " << seed);
    // Implicit Euler's solver leaves 1e-8 m/s a step of some 10 g; Verlet rounds impulses to
    // floats.
    CHECK((momentum_kg_m_per_s(simulation.world()) - momentum).norm() <
          (scene::is_explicit(kind) ? 1e-6 * momentum.norm() : 1e-8));
    if (scene::is_explicit(kind))
      CHECK((angular_momentum_kg_m2_per_s(simulation.world()) - spin).norm() < 1e-6 * spin.norm());
  }
}

TEST_CASE("By implicit Euler the error of their spin falls with the step", "[joints]") {
  double coarse = 0.0, fine = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    coarse += angular_error(seed, {}, 1e-3);
    fine += angular_error(seed, {}, 2.5e-4);
  }
  CHECK(fine < 0.75 * coarse);
}

TEST_CASE("Joints never make energy by implicit Euler, however they are turned", "[joints]") {
  const double damping_N_s_per_m = GENERATE(0.0, 0.5);
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Simulation simulation(drawn_chain(seed, damping_N_s_per_m, kGravity_m_s2, true));
    double before_J = energies_of(simulation).total_J();
    double made_J = 0.0;
    for (int i = 0; i < 300; ++i) {
      REQUIRE(advance(simulation, 0.01, 1));
      const double now_J = energies_of(simulation).total_J();
      made_J = std::max(made_J, now_J - before_J);
      before_J = now_J;
    }
    INFO("seed " << seed);
    CHECK(made_J < 1e-8);
  }
}

/// How far all energy was from that of the start, and the largest kinetic energy.
struct EnergySpan {
  double least_J = 0.0, most_J = 0.0, kinetic_J = 0.0;
};
EnergySpan energy_span(const scene::SceneDescription& scene, double step_s, int steps) {
  Simulation simulation(scene);
  const double start_J = energies_of(simulation).total_J();
  EnergySpan span;
  for (int i = 0; i < steps; ++i) {
    (void)advance(simulation, step_s, 1);
    const Energies now = energies_of(simulation);
    span.least_J = std::min(span.least_J, now.total_J() - start_J);
    span.most_J = std::max(span.most_J, now.total_J() - start_J);
    span.kinetic_J = std::max(span.kinetic_J, now.kinetic_J);
  }
  return span;
}

TEST_CASE("By explicit methods energy stays, however stiff the joints are", "[joints]") {
  const scene::IntegratorKind kind = scene::IntegratorKind::kVelocityVerlet;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    scene::SceneDescription scene = drawn_chain(seed, 0.0, kGravity_m_s2, true);
    scene.method.integrator = kind;
    const EnergySpan span = energy_span(scene, 0.01, 200);
    INFO(kind.name << ", seed " << seed);
    CHECK(std::max(-span.least_J, span.most_J) < 0.1 * span.kinetic_J);
  }
}

/// A box that hangs from the world by a joint and bears another, of masses, sizes, springs and
/// dampers that are drawn over decades: joints become as long as the boxes or a thousand times
/// that.
scene::SceneDescription drawn_load(unsigned seed) {
  std::mt19937 random(seed);
  const auto by_decades = [&](double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution<double>()(random));
  };
  const double own_m = by_decades(0.004, 0.04), load_m = by_decades(0.004, 0.04);
  bodies::BodyDescription own =
      link({0, 0, 0}, Eigen::Vector3d::Constant(own_m), by_decades(1e-4, 0.1));
  own.angular_velocity_rad_s = {by_decades(0.1, 10.0), 0.0, by_decades(0.1, 10.0)};
  const bodies::BodyDescription load =
      link({0, 0, -own_m - load_m}, Eigen::Vector3d::Constant(load_m), by_decades(1e-3, 5.0));
  const auto damping_N_s_per_m = [&] { return random() % 2 == 0 ? 0.0 : by_decades(1e-3, 1.0); };
  const double hold_N_per_m = by_decades(1.0, 1e3), bear_N_per_m = by_decades(1.0, 1e3);
  const bool is_first = random() % 2 == 0;
  return joined_scene({own, load},
                      {joint(0, -1, {{0.0, 0.0, own_m}}, hold_N_per_m, damping_N_s_per_m()),
                       joint(is_first ? 0 : 1, is_first ? 1 : 0, {{0.0, 0.0, -own_m}}, bear_N_per_m,
                             damping_N_s_per_m())},
                      kGravity_m_s2);
}

TEST_CASE("By explicit methods joints that are stretched far make no energy", "[joints]") {
  const scene::IntegratorKind kind = scene::IntegratorKind::kVelocityVerlet;
  for (unsigned seed = 1; seed <= 3 * kSeeds; ++seed) {
    scene::SceneDescription scene = drawn_load(seed);
    scene.method.integrator = kind;
    const EnergySpan span = energy_span(scene, 0.017, 150);
    INFO(kind.name << ", seed " << seed);
    CHECK(span.most_J < 0.2 * span.kinetic_J);
  }
}

TEST_CASE("The account of a joint's energy closes, led or not", "[joints]") {
  // Its end is led to and fro; finer steps leave less that no row names.
  const scene::IntegratorKind kind = GENERATE(from_range(kBothIntegrators));
  const auto left_J = [&](double step_s) {
    bodies::BodyDescription hand = link({0, 0, 0}, {0.02, 0.02, 0.02}, 0.0);
    hand.motion = bodies::Motion::kPrescribed;
    hand.prescribed = {
        .direction = Eigen::Vector3d::UnitX(), .amplitude_m = 0.01, .frequency_hz = 2.0};
    scene::SceneDescription scene =
        joined_scene({hand, link({0, 0, -0.05}, {0.02, 0.01, 0.04}, 0.05)},
                     {joint(0, 1, {{0.0, 0.0, -0.03}}, 500.0, 0.5)}, kGravity_m_s2);
    scene.method.integrator = kind;
    Simulation simulation(scene);
    simulation.account_energy();
    (void)advance(simulation, step_s, static_cast<int>(std::lround(1.0 / step_s)));
    const EnergyAccount account = *simulation.energy_account();
    CHECK(account.flow.given_J > 1e-4);
    CHECK(account.flow.spring_damping_J > 1e-5);
    return std::abs(account.numerical_J());
  };
  const double coarse_J = left_J(1e-3), fine_J = left_J(2.5e-4);
  INFO(kind.name << ": " << coarse_J << " J, " << fine_J << " J");
  CHECK(fine_J < 0.4 * coarse_J + 1e-7);
}

TEST_CASE("A body hangs m g / k below the place where it is joined", "[joints]") {
  const scene::IntegratorKind kind = GENERATE(from_range(kBothIntegrators));
  const bool is_of_nodes = GENERATE(false, true);
  CHECK(hanging_share({.integrator = kind}, is_of_nodes) == Approx(1.0).epsilon(1e-4));
}

TEST_CASE("A rod swings with the period of a physical pendulum", "[joints]") {
  const scene::IntegratorKind kind = GENERATE(from_range(kBothIntegrators));
  const bool is_hinge = GENERATE(false, true);
  CHECK(swing_share({.integrator = kind}, is_hinge) == Approx(1.0).epsilon(2e-3));
}

TEST_CASE("A weld keeps the angle of its bodies, and a hinge that about two axes", "[joints]") {
  const int points = GENERATE(2, 3);
  std::vector<Eigen::Vector3d> points_m = {{0, -0.01, 0}, {0, 0.01, 0}};
  if (points == 3) points_m.emplace_back(0.0, 0.0, 0.01);
  Simulation simulation(joined_scene(
      {link({-0.03, 0, 0}, {0.06, 0.02, 0.02}, 0.05),
       sim_server::moving(link({0.03, 0, 0}, {0.06, 0.02, 0.02}, 0.05), {0, 0, 0}, {0, 2.0, 1.0})},
      {joint(0, 1, points_m, 1e4, 2.0)}));

  REQUIRE(advance(simulation, 0.002, 500));

  const auto& rigid = simulation.world().rigid_bodies;
  const Eigen::AngleAxisd turn(rigid[0].orientation.conjugate() * rigid[1].orientation);
  const Eigen::Vector3d turned_rad = turn.angle() * turn.axis();
  CHECK(std::abs(turned_rad.x()) < 0.02);
  CHECK(std::abs(turned_rad.z()) < 0.02);
  CHECK((std::abs(turned_rad.y()) < 0.02) == (points == 3));
}

}  // namespace
}  // namespace stillgrid::dynamics::joints_test
