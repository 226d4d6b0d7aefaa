#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/laboratory/two_rate.hpp"

namespace stillgrid::laboratory::two_rate::virtual_coupling_test {
namespace {

/// A tool mass between the device and a wall, advanced once a tick: by implicit Euler, or by
/// symplectic Euler from what it knew at the tick's start. Damping sees backward differences.
struct Coupling {
  double damping_N_s_per_m = 0.0;
  double tool_mass_kg = 0.1;
  double wall_N_per_m = 0.0;
  bool is_implicit = true;
};

/// One tick's map of device position and velocity, last stretch, tool position and velocity.
Eigen::MatrixXd coupled_tick(const Coupling& coupling, double coupling_N_per_m) {
  using Row = Eigen::Matrix<double, 1, 5>;
  const HeldTick device = held_tick({0.1, 1.0, 0.0});
  const double c = coupling.damping_N_s_per_m / kTick_s, m = coupling.tool_mass_kg;
  const Row device_m = Row::Unit(0), last_stretch_m = Row::Unit(2);
  const Row tool_m = Row::Unit(3), tool_m_s = Row::Unit(4);
  const Row stretch_m = device_m - tool_m;

  const Row force_N = coupling_N_per_m * stretch_m + c * (stretch_m - last_stretch_m) -
                      coupling.wall_N_per_m * tool_m;
  const double stiffness_N_per_m = coupling_N_per_m + c + coupling.wall_N_per_m;
  const double inertia_kg = coupling.is_implicit ? m + kTick_s * kTick_s * stiffness_N_per_m : m;
  const Row next_m_s = (m * tool_m_s + kTick_s * force_N) / inertia_kg;
  const Row next_m = tool_m + kTick_s * next_m_s;
  const Row next_stretch_m = device_m - next_m;
  const Row on_device_N =
      -coupling_N_per_m * next_stretch_m - c * (next_stretch_m - last_stretch_m);

  Eigen::MatrixXd map(5, 5);
  map.topRows(2) = device.input * on_device_N;
  map.topLeftCorner<2, 2>() += device.transition;
  map.row(2) = next_stretch_m;
  map.row(3) = next_m;
  map.row(4) = next_m_s;
  return map;
}

double limit_N_per_m(const Coupling& coupling) {
  const auto limit = stiffness_limit(
      [&](double coupling_N_per_m) { return coupled_tick(coupling, coupling_N_per_m); });
  return limit ? limit->limit_N_per_m : INFINITY;
}

TEST_CASE("A virtual coupling to an implicit tool bears what a wall bears, however stiff the scene",
          "[virtual_coupling]") {
  const auto [damping_N_s_per_m, wall_limit_N_per_m] =
      GENERATE(std::pair(0.0, 2003.34), std::pair(0.5, 2990.1));
  const double tool_mass_kg = GENERATE(0.01, 0.1, 1.0);

  double worst_N_per_m = INFINITY;
  for (double wall_N_per_m = 1e-3; wall_N_per_m < 2e9; wall_N_per_m *= 10.0)
    worst_N_per_m =
        std::min(worst_N_per_m, limit_N_per_m({damping_N_s_per_m, tool_mass_kg, wall_N_per_m}));

  CHECK(worst_N_per_m == Approx(wall_limit_N_per_m).epsilon(2e-5));
}

TEST_CASE("A virtual coupling to an explicit tool bears nothing where the scene is too stiff",
          "[virtual_coupling]") {
  const double tool_mass_kg = GENERATE(0.01, 0.1, 1.0);
  const double explicit_limit_N_per_m = 4.0 * tool_mass_kg / (kTick_s * kTick_s);

  CHECK(limit_N_per_m({0.0, tool_mass_kg, 1.01 * explicit_limit_N_per_m, false}) == 0.0);
  CHECK(limit_N_per_m({0.0, tool_mass_kg, 0.9 * explicit_limit_N_per_m, false}) > 10.0);
  CHECK(limit_N_per_m({0.0, tool_mass_kg, 100.0, false}) == Approx(1000.0).epsilon(0.05));
}

}  // namespace
}  // namespace stillgrid::laboratory::two_rate::virtual_coupling_test
