#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::oscillator_test {
namespace {

/// A mass of 0.1 kg on a spring of 1000 N/m whose other end is pinned, 0.1 m long at rest.
Simulation oscillator(double damping_N_s_per_m = 0.0) {
  bodies::BodyDescription body = sim_server::thread(2, {0, 0, 0}, {0.1, 0, 0}, 0.1, 1000.0, {0});
  sim_server::springs(body).spring_damping_N_s_per_m = damping_N_s_per_m;
  return Simulation(sim_server::scene_of({body}));
}

/// Stretch and velocity of the mass, along the spring.
Eigen::Vector2d state_of(const Simulation& simulation) {
  const bodies::Node& mass = simulation.world().nodes[1];
  return {mass.position_m.x() - 0.1, mass.velocity_m_s.x()};
}

void set_state(Simulation& simulation, const Eigen::Vector2d& state) {
  bodies::Node& mass = simulation.world().nodes[1];
  mass.position_m.x() = 0.1 + state[0];
  mass.velocity_m_s.x() = state[1];
}

TEST_CASE("An oscillator loses energy by 1 + w^2 h^2 a step", "[known_answers]") {
  const auto [step_s, expected] =
      GENERATE(std::pair(0.01, std::pow(2.0, -10)), std::pair(0.001, 0.905287));
  Simulation simulation = oscillator();
  set_state(simulation, {0.004, -0.3});
  const double start_J = bodies::mechanical_energy_J(simulation.world());

  REQUIRE(advance(simulation, step_s, 10));

  const double ratio = bodies::mechanical_energy_J(simulation.world()) / start_J;
  CHECK(ratio == Approx(std::pow(1.0 + 1e4 * step_s * step_s, -10)).epsilon(1e-9));
  CHECK(std::abs(ratio - expected) < 5e-7);  // the catalogue's digits
}

TEST_CASE("A string under tension pulls its middle back by 2 k (1 - r) times the displacement",
          "[known_answers]") {
  const double rest_ratio = GENERATE(0.5, 0.8, 1.0), step_s = 1e-3, start_m = 1e-6;
  bodies::BodyDescription string =
      sim_server::thread(3, {0, 0, 0}, {0.2, 0, 0}, 0.1, 1000.0, {0, 2});
  sim_server::springs(string).spring_rest_ratio = rest_ratio;
  scene::SceneDescription scene = sim_server::scene_of({string});
  scene.method.tolerance_m_s = 1e-14;
  Simulation simulation(scene);
  simulation.world().nodes[1].position_m.y() = start_m;

  REQUIRE(advance(simulation, step_s, 1));

  const double square_per_s2 = 2.0 * 1000.0 * (1.0 - rest_ratio) / 0.1;
  const double expected_m_s =
      -step_s * square_per_s2 * start_m / (1.0 + step_s * step_s * square_per_s2);
  const bodies::Node& middle = simulation.world().nodes[1];
  CHECK(middle.velocity_m_s.y() == Approx(expected_m_s).epsilon(1e-4).margin(1e-11));
  CHECK(std::abs(middle.velocity_m_s.x()) < 1e-11);
}

TEST_CASE("A damped oscillator shrinks by 1 + h c / m + h^2 k / m a step", "[known_answers]") {
  const double damping_N_s_per_m = GENERATE(0.0, 2.0, 20.0);
  const double step_s = GENERATE(0.001, 0.01, 0.1);
  // Two states span the plane: the determinant of one step is |lambda|^2.
  Eigen::Matrix2d start = 1e-3 * Eigen::Matrix2d::Identity(), end;
  for (int i = 0; i < 2; ++i) {
    Simulation simulation = oscillator(damping_N_s_per_m);
    set_state(simulation, start.col(i));
    REQUIRE(advance(simulation, step_s, 1));
    end.col(i) = state_of(simulation);
  }

  const double shrinking = (end * start.inverse()).determinant();

  const double law =
      1.0 / (1.0 + step_s * damping_N_s_per_m / 0.1 + step_s * step_s * 1000.0 / 0.1);
  CHECK(shrinking == Approx(law).epsilon(1e-9));
  if (damping_N_s_per_m == 2.0 && step_s == 0.01) CHECK(std::abs(shrinking - 0.454545) < 5e-7);
}

TEST_CASE("A stiff dumbbell's spin fades as implicit Euler's does", "[known_answers]") {
  // tan th1 = w0 h, then tan th' = sin th / (2 - cos th) a step; L/L0 = sin(th) / (h w0).
  const auto [spin_rad_s, step_s, expected] =
      GENERATE(std::tuple(10.0, 0.01, 0.57805), std::tuple(10.0, 0.001, 0.91291),
               std::tuple(5.0, 0.01, 0.81711));
  Simulation simulation(sim_server::scene_of(
      {sim_server::moving(sim_server::thread(2, {-0.05, 0, 0}, {0.05, 0, 0}, 0.1, 1e9), {0, 0, 0},
                          {0, 0, spin_rad_s})}));
  const auto angular_momentum = [&] {
    double sum = 0.0;
    for (const bodies::Node& node : simulation.world().nodes)
      sum += node.mass_kg * node.position_m.cross(node.velocity_m_s).z();
    return sum;
  };
  const double start = angular_momentum();

  REQUIRE(advance(simulation, step_s, static_cast<int>(std::lround(1.0 / step_s))));

  // At 1e9 N/m the bar stretches by m w^2 L / 2k, a few 1e-9 of its length.
  CHECK(std::abs(angular_momentum() / start - expected) < 5e-5);
}

/// A mass of 10 g between two springs of 1000 N/m.
scene::SceneDescription two_springs() {
  return sim_server::scene_of(
      {sim_server::thread(3, {-0.02, 0, 0}, {0.02, 0, 0}, 0.01, 1000.0, {0, 2})});
}

/// Presses the springs from 20 to 16 mm each, with the mass a little beside their line.
void press(bodies::World& world, double off_axis_m) {
  world.nodes[0].position_m.x() = -0.016;
  world.nodes[2].position_m.x() = 0.016;
  world.nodes[1].position_m.y() = off_axis_m;
}

TEST_CASE("Below the critical step pressed springs stay where their inertia holds them",
          "[known_answers]") {
  // m / h^2 > k (L0/L - 1) twice: h < 4.472 ms. There y = eps / (1 - (h / h_crit)^2).
  const double off_axis_m = 1e-7, step_s = GENERATE(0.001, 0.003);
  Simulation simulation(two_springs());
  press(simulation.world(), off_axis_m);

  REQUIRE(advance(simulation, step_s, 1));

  const double ratio = step_s / std::sqrt(0.01 / 500.0);
  CHECK(simulation.world().nodes[1].position_m.y() ==
        Approx(off_axis_m / (1.0 - ratio * ratio)).epsilon(1e-3));
}

/// Of the step, at a place aside: what implicit Euler makes least.
double step_energy_J(double aside_m, double off_axis_m, double step_s) {
  const double stretch_m = std::hypot(0.016, aside_m) - 0.02;
  return 0.5 * 0.01 / (step_s * step_s) * std::pow(aside_m - off_axis_m, 2) +
         1000.0 * stretch_m * stretch_m;
}

TEST_CASE("Beyond it they snap aside, and the solver does not stop on the saddle",
          "[known_answers]") {
  const double off_axis_m = GENERATE(1e-4, 1e-6), step_s = 0.01;
  Simulation simulation(two_springs());
  press(simulation.world(), off_axis_m);

  REQUIRE(advance(simulation, step_s, 1));

  const double aside_m = simulation.world().nodes[1].position_m.y();
  const double energy_J = step_energy_J(aside_m, off_axis_m, step_s);
  CHECK(aside_m == Approx(0.010335).margin(5e-7 + off_axis_m));
  CHECK(energy_J == Approx(0.0062466).margin(5e-8 + 2.0 * off_axis_m));
}

}  // namespace
}  // namespace stillgrid::dynamics::oscillator_test
