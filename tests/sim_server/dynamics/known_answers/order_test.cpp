#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::order_test {
namespace {

constexpr int kMasses = 10;

/// A chain of ten masses of 10 g and springs of 1000 N/m, one end pinned, along x.
scene::SceneDescription chain() {
  return sim_server::scene_of(
      {sim_server::thread(kMasses + 1, {0, 0, 0}, {1, 0, 0}, 0.01, 1000.0, {0})});
}

/// The largest error over half a second against the first mode, let go at rest.
double error_m(scene::IntegratorKind kind, double step_s) {
  scene::SceneDescription scene = chain();
  scene.method = {
      .integrator = kind, .substeps = scene::is_explicit(kind) ? 1 : 0, .tolerance_m_s = 1e-11};
  scene.sleeping = false;
  Simulation simulation(scene);
  bodies::World& world = simulation.world();
  const double x = std::numbers::pi / (2 * kMasses + 1);
  const double rate_rad_s = 2.0 * std::sqrt(1000.0 / 0.01) * std::sin(0.5 * x);
  const auto stretch_m = [&](int mass, double time_s) {
    return 1e-3 * std::sin(mass * x) * std::cos(rate_rad_s * time_s);
  };
  for (int i = 1; i <= kMasses; ++i)
    world.nodes[static_cast<std::size_t>(i)].position_m.x() += stretch_m(i, 0.0);
  double worst_m = 0.0;
  for (int step = 1; step <= std::lround(0.5 / step_s); ++step) {
    REQUIRE(advance(simulation, step_s, 1));
    for (int i = 1; i <= kMasses; ++i)
      worst_m = std::max(worst_m, std::abs(world.nodes[static_cast<std::size_t>(i)].position_m.x() -
                                           0.1 * i - stretch_m(i, step * step_s)));
  }
  return worst_m;
}

TEST_CASE("Implicit Euler's error falls as the step, Verlet's as its square", "[known_answers]") {
  const auto [kind, order, margin] =
      GENERATE(std::tuple(scene::IntegratorKind::kImplicitEuler, 1.0, 0.06),
               std::tuple(scene::IntegratorKind::kVelocityVerlet, 2.0, 0.01));

  CHECK(std::log2(error_m(kind, 1e-4) / error_m(kind, 5e-5)) == Approx(order).margin(margin));
}

}  // namespace
}  // namespace stillgrid::dynamics::order_test
