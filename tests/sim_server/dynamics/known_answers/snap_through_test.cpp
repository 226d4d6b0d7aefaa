#include <catch2/catch.hpp>
#include <cmath>
#include <utility>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::snap_through_test {
namespace {

constexpr double kHalfSpan_m = 0.1, kHeight_m = 0.03, kStiffness_N_per_m = 1000.0, kMass_kg = 0.1;

/// Two bars that lean on each other, loaded at the top by its weight.
Simulation truss(double load_N) {
  const scene::SceneDescription scene =
      sim_server::scene_of({sim_server::thread(3, {-kHalfSpan_m, 0, 0}, {kHalfSpan_m, 0, 0},
                                               kMass_kg, kStiffness_N_per_m, {0, 2})},
                           {}, {0, 0, -load_N / kMass_kg});
  bodies::World world = scene::build_world(scene);
  world.nodes[1].position_m.z() = kHeight_m;
  for (bodies::Spring& bar : world.springs) bar.rest_length_m = std::hypot(kHalfSpan_m, kHeight_m);
  return Simulation(scene, std::move(world));
}

/// The greatest load that it bears, and the height at which it does.
struct Limit {
  double height_m, load_N;
};
Limit limit() {
  const double length_m = std::hypot(kHalfSpan_m, kHeight_m), b2 = kHalfSpan_m * kHalfSpan_m;
  const double height_m = std::sqrt(std::pow(length_m * b2, 2.0 / 3.0) - b2);
  return {height_m, 2.0 * kStiffness_N_per_m * height_m *
                        (length_m / std::hypot(kHalfSpan_m, height_m) - 1.0)};
}

TEST_CASE("A shallow truss bears 0.994992 N, at a height of 17.0712 mm", "[known_answers]") {
  CHECK(std::abs(limit().height_m - 0.0170712) < 5e-8);
  CHECK(std::abs(limit().load_N - 0.994992) < 5e-7);
}

TEST_CASE("Beyond its limit a truss snaps through to -34.9349 mm", "[known_answers]") {
  Simulation simulation = truss(1.01 * limit().load_N);

  REQUIRE(advance(simulation, 0.05, 100));
  REQUIRE(advance(simulation, 1.0, 100));

  CHECK(std::abs(simulation.world().nodes[1].position_m.z() - -0.0349349) < 5e-8);
}

}  // namespace
}  // namespace stillgrid::dynamics::snap_through_test
