#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::collision_test {
namespace {

constexpr double kRadius_m = 0.05;

struct Collision {
  double velocity_a_m_s = 0.0, velocity_b_m_s = 0.0;  // after it
  double time_s = 0.0, depth_m = 0.0;                 // of contact, greatest
  double momentum_drift_N_s = 0.0;                    // of momentum, greatest
};

/// Balls of 0.1 and 0.3 kg at 1 and -0.2 m/s, gap_m apart, of 1000 N/m.
Collision collide(double step_s, double gap_m) {
  Simulation simulation(sim_server::scene_of(
      {sim_server::moving(sim_server::sphere({0, 0, 0}, kRadius_m, 0.1), {1, 0, 0}),
       sim_server::moving(sim_server::sphere({2.0 * kRadius_m + gap_m, 0, 0}, kRadius_m, 0.3),
                          {-0.2, 0, 0})},
      sim_server::material_of(1000.0)));
  const bodies::RigidBody& a = simulation.world().rigid_bodies[0];
  const bodies::RigidBody& b = simulation.world().rigid_bodies[1];
  Collision result;
  for (bool touched = false;;) {
    const StepReport report = simulation.step(step_s, no_tool);
    REQUIRE(report.solve.converged);
    result.depth_m =
        std::max(result.depth_m, 2.0 * kRadius_m - (b.position_m - a.position_m).norm());
    result.momentum_drift_N_s = std::max(
        result.momentum_drift_N_s,
        (0.1 * a.velocity_m_s + 0.3 * b.velocity_m_s - Eigen::Vector3d(0.04, 0, 0)).norm());
    if (report.contacts > 0) result.time_s += step_s;
    if (touched && report.contacts == 0) break;
    touched = touched || report.contacts > 0;
  }
  result.velocity_a_m_s = a.velocity_m_s.x();
  result.velocity_b_m_s = b.velocity_m_s.x();
  return result;
}

/// Implicit Euler's restitution in the reduced mass of 75 g, averaged over the phase.
double restitution(double step_s) {
  const double wh = std::sqrt(1000.0 / 0.075) * step_s;
  return std::pow(1.0 + wh * wh, -std::acos(-1.0) / (2.0 * std::atan(wh)));
}

TEST_CASE("Two balls leave as implicit Euler's restitution says", "[known_answers]") {
  const auto [step_s, known_m_s] = GENERATE(std::pair(1e-3, -0.6510), std::pair(1e-4, -0.7838));
  constexpr int kPhases = 12;
  double mean_m_s = 0.0, lowest_m_s = 1.0, highest_m_s = -1.0;
  for (int i = 0; i < kPhases; ++i) {
    const Collision result = collide(step_s, 1.2 * step_s * i / kPhases);
    mean_m_s += result.velocity_a_m_s / kPhases;
    lowest_m_s = std::min(lowest_m_s, result.velocity_a_m_s);
    highest_m_s = std::max(highest_m_s, result.velocity_a_m_s);
  }

  // 0.1 m/s of the centre of mass, less 0.3 / 0.4 of the relative speed of 1.2 m/s that is left.
  const double law_m_s = 0.1 - 0.9 * restitution(step_s);
  CHECK(std::abs(law_m_s - known_m_s) < 5e-5);
  CHECK(lowest_m_s <= law_m_s + 1e-4);
  CHECK(highest_m_s >= law_m_s - 1e-4);
  // The phase spreads restitution by at most (wh)^2 / 5 either way.
  CHECK(highest_m_s - lowest_m_s < 0.9 * 0.4 * step_s * step_s * 1000.0 / 0.075);
  CHECK(std::abs(mean_m_s - law_m_s) < 0.9 * 0.2 * step_s * step_s * 1000.0 / 0.075);
}

TEST_CASE("Two balls keep their momentum to the solver's tolerance", "[known_answers]") {
  // 1e-8 m/s a step of 0.4 kg, over the steps in which they touch: some 30 and 300.
  CHECK(collide(1e-3, 0.0005).momentum_drift_N_s <= 30 * 4e-9);
  CHECK(collide(1e-4, 0.00005).momentum_drift_N_s <= 300 * 4e-9);
}

TEST_CASE("As the step shrinks two balls exchange velocities as in a perfect collision",
          "[known_answers]") {
  const Collision coarse = collide(2e-5, 0.0), fine = collide(1e-5, 0.0);

  CHECK(std::abs(fine.velocity_a_m_s - -0.7984) < 5e-5);
  CHECK((coarse.velocity_a_m_s + 0.8) / (fine.velocity_a_m_s + 0.8) == Approx(2.0).epsilon(0.01));
  CHECK(2.0 * fine.velocity_a_m_s - coarse.velocity_a_m_s == Approx(-0.8).margin(1e-5));
  CHECK(2.0 * fine.velocity_b_m_s - coarse.velocity_b_m_s == Approx(0.4).margin(1e-5));
  CHECK(2.0 * fine.depth_m - coarse.depth_m == Approx(0.0103923).margin(1e-7));
  CHECK(fine.time_s == Approx(0.027207).margin(2e-5));  // two steps: begun and left within one
}

}  // namespace
}  // namespace stillgrid::dynamics::collision_test
