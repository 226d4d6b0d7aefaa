#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::bounce_test {
namespace {

constexpr double kRadius_m = 0.05, kMass_kg = 0.1, kStiffness_N_per_m = 1000.0;  // 100 rad/s

struct Bounce {
  double restitution = 0.0;  // speed after over speed before
  double depth_m = 0.0;      // greatest
};

/// A ball that comes down on the floor at 1 m/s from gap_m above it, until it is off again.
Bounce bounce(double step_s, double gap_m, double damping_N_s_per_m = 0.0,
              double gravity_m_s2 = 0.0) {
  Simulation simulation(sim_server::scene_of(
      {sim_server::moving(sim_server::sphere({0, 0, kRadius_m + gap_m}, kRadius_m, kMass_kg),
                          {0, 0, -1}),
       sim_server::floor_at(0.0)},
      sim_server::material_of(kStiffness_N_per_m, damping_N_s_per_m), {0, 0, -gravity_m_s2}));
  const bodies::RigidBody& ball = simulation.world().rigid_bodies[0];
  Bounce result;
  for (bool touched = false;;) {
    const StepReport report = simulation.step(step_s, no_tool);
    REQUIRE(report.solve.converged);
    result.depth_m = std::max(result.depth_m, kRadius_m - ball.position_m.z());
    if (touched && report.contacts == 0) break;
    touched = touched || report.contacts > 0;
  }
  result.restitution = ball.velocity_m_s.z();
  return result;
}

/// The same as a recursion in one number, undamped: what implicit Euler means here.
double scalar_restitution(double step_s, double gap_m) {
  double height_m = gap_m, velocity_m_s = -1.0;
  while (velocity_m_s < 0.0 || height_m < 0.0) {
    if (height_m + step_s * velocity_m_s < 0.0)
      velocity_m_s = (velocity_m_s - step_s * kStiffness_N_per_m / kMass_kg * height_m) /
                     (1.0 + step_s * step_s * kStiffness_N_per_m / kMass_kg);
    height_m += step_s * velocity_m_s;
  }
  return velocity_m_s;
}

TEST_CASE("A ball bounces as the scalar recursion of implicit Euler does", "[known_answers]") {
  const double step_s = GENERATE(0.001, 0.003, 0.005);
  for (const double phase : {0.0, 0.1, 0.37, 0.5, 0.83, 0.99})
    CHECK(bounce(step_s, phase * step_s).restitution ==
          Approx(scalar_restitution(step_s, phase * step_s)).epsilon(1e-7));
}

TEST_CASE("Implicit Euler's own restitution is (1 + w^2 h^2)^(-pi / (2 atan wh))",
          "[known_answers]") {
  // Over the phase of touch within the step it spreads about that; the catalogue's ranges.
  struct Case {
    double step_s, formula, lowest, highest;
  };
  const Case known =
      GENERATE(Case{0.001, 0.8549, 0.8538, 0.8560}, Case{0.003, 0.6285, 0.6238, 0.6333},
               Case{0.005, 0.4695, 0.4605, 0.4792});
  const double wh = 100.0 * known.step_s;
  constexpr int kPhases = 50;
  double lowest = 1.0, highest = 0.0, mean = 0.0;
  for (int i = 0; i < kPhases; ++i) {
    const double e = bounce(known.step_s, known.step_s * i / kPhases).restitution;
    lowest = std::min(lowest, e);
    highest = std::max(highest, e);
    mean += e / kPhases;
  }

  const double formula = std::pow(1.0 + wh * wh, -std::numbers::pi / (2.0 * std::atan(wh)));
  CHECK(std::abs(formula - known.formula) < 5e-5);
  CHECK(std::abs(mean - formula) < 5e-4);
  CHECK(lowest > known.lowest - 5e-5);
  CHECK(highest < known.highest + 5e-5);
}

/// The limit of vanishing steps from two of them, the error being of first order.
Bounce limit(double damping_N_s_per_m, double gravity_m_s2) {
  const Bounce coarse = bounce(2e-5, 0.0, damping_N_s_per_m, gravity_m_s2);
  const Bounce fine = bounce(1e-5, 0.0, damping_N_s_per_m, gravity_m_s2);
  return {2.0 * fine.restitution - coarse.restitution, 2.0 * fine.depth_m - coarse.depth_m};
}

TEST_CASE("The approach damper restores exp(-(z/q) acos z), not the two-sided damper's",
          "[known_answers]") {
  const auto [zeta, expected] = GENERATE(std::pair(0.2, 0.756135), std::pair(0.5, 0.546293));
  const double q = std::sqrt(1.0 - zeta * zeta);
  const double law = std::exp(-zeta / q * std::acos(zeta));

  const Bounce result = limit(2.0 * zeta * std::sqrt(kStiffness_N_per_m * kMass_kg), 0.0);

  // Second order is left: (wh)^2 = 1e-6 and 4e-6, some tens of times.
  CHECK(std::abs(law - expected) < 5e-7);
  CHECK(std::abs(result.restitution - law) < 1e-4);
  CHECK(std::abs(result.depth_m - law / 100.0) < 1e-6);  // (v / w) exp(-(z/q) acos z)
}

TEST_CASE("Restitution converges to the law in first order", "[known_answers]") {
  const double law = std::exp(-0.2 / std::sqrt(0.96) * std::acos(0.2));
  const double coarse = bounce(2e-4, 0.0, 4.0).restitution - law;
  const double fine = bounce(1e-4, 0.0, 4.0).restitution - law;

  CHECK(coarse / fine == Approx(2.0).epsilon(0.05));
}

TEST_CASE("An undamped drop sinks 11.0290 mm and bounces back whole", "[known_answers]") {
  const Bounce result = limit(0.0, 9.81);

  const double static_m = kMass_kg * 9.81 / kStiffness_N_per_m;
  const double law_m = static_m + std::sqrt(static_m * static_m + 1e-4);
  CHECK(std::abs(law_m - 0.0110290) < 5e-8);
  CHECK(std::abs(result.depth_m - law_m) < 1e-7);
  CHECK(std::abs(result.restitution - 1.0) < 1e-4);
}

}  // namespace
}  // namespace stillgrid::dynamics::bounce_test
