#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <random>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::cloth_test {
namespace {

/// A sheet of 8 x 8 nodes, 20 mm apart, of 2 g each, hanging down from where it is pinned.
bodies::BodyDescription hanging_cloth(std::vector<int> pinned) {
  bodies::BodyDescription body = sim_server::sheet({8, 8}, 0.02, 0.002, 500.0);
  body.orientation = Eigen::AngleAxisd(0.5 * std::acos(-1.0), Eigen::Vector3d::UnitX());
  body.position_m.z() = -0.07;  // the upper edge at height 0
  sim_server::packing(body) = {0.02, 1e-4};
  sim_server::springs(body).pinned_nodes = std::move(pinned);
  return body;
}

TEST_CASE("A cloth pinned along its top hangs as eight chains", "[known_answers]") {
  Simulation simulation(
      sim_server::scene_of({hanging_cloth({56, 57, 58, 59, 60, 61, 62, 63})}, {}, {0, 0, -9.81}));

  REQUIRE(advance(simulation, 10.0, 10));  // steps so long that little but statics is left

  for (std::size_t i = 0; i < 8; ++i)
    CHECK(simulation.world().nodes[i].position_m.z() == Approx(-0.14109872).epsilon(1e-9));
}

/// Springs of 500 N/m and more that shear and bend less, pinned at its upper corners.
struct CornerCase {
  double structural, shear, bend;  // N/m
  double energy_J, mean_m, lowest_m;
};

/// Moves every free node by up to 5 mm any way, half the most that keeps neighbours apart.
void crumple(bodies::World& world, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> offset_m(-0.005, 0.005);
  for (bodies::Node& node : world.nodes)
    if (!node.pinned)
      node.position_m += Eigen::Vector3d(offset_m(random), offset_m(random), offset_m(random));
}

TEST_CASE("A cloth pinned at two corners comes to the one state of least energy, however crumpled",
          "[known_answers]") {
  const CornerCase known =
      GENERATE(CornerCase{500, 250, 50, -0.08898932377445, -0.0717191791594, -0.1419600196581},
               CornerCase{5000, 2500, 500, -0.0880091398831, -0.0701774331113, NAN});
  const std::uint64_t seed = GENERATE(1u, 2u, 3u);
  bodies::BodyDescription body = hanging_cloth({56, 63});
  sim_server::springs(body).structural_stiffness_N_per_m = known.structural;
  sim_server::shear_stiffness_N_per_m(body) = known.shear;
  sim_server::springs(body).bend_stiffness_N_per_m = known.bend;
  scene::SceneDescription scene = sim_server::scene_of({body}, {}, {0, 0, -9.81});
  Simulation simulation(scene);
  crumple(simulation.world(), seed);

  REQUIRE(advance(simulation, 0.05, 100));
  REQUIRE(advance(simulation, 1.0, 100));

  double mean_m = 0.0, lowest_m = 0.0;
  for (const bodies::Node& node : simulation.world().nodes) {
    mean_m += node.position_m.z() / 64.0;
    lowest_m = std::min(lowest_m, node.position_m.z());
  }
  CHECK(bodies::mechanical_energy_J(simulation.world()) == Approx(known.energy_J).epsilon(1e-9));
  CHECK(mean_m == Approx(known.mean_m).epsilon(1e-7));
  if (std::isfinite(known.lowest_m)) CHECK(lowest_m == Approx(known.lowest_m).epsilon(1e-7));
}

TEST_CASE("From flat a cloth comes to where it hangs, though its static slope is singular there",
          "[known_answers]") {
  // Of its 62 free nodes none is held against leaving the plane.
  bodies::BodyDescription body = sim_server::sheet({8, 8}, 0.02, 0.002, 500.0);
  sim_server::shear_stiffness_N_per_m(body) = 250.0;
  sim_server::springs(body).bend_stiffness_N_per_m = 50.0;
  sim_server::springs(body).pinned_nodes = {0, 7};
  Simulation simulation(sim_server::scene_of({body}, {}, {0, 0, -9.81}));

  REQUIRE(advance(simulation, 0.05, 100));
  REQUIRE(advance(simulation, 1.0, 100));

  CHECK(bodies::mechanical_energy_J(simulation.world()) == Approx(-0.08898932377445).epsilon(1e-9));
}

}  // namespace
}  // namespace stillgrid::dynamics::cloth_test
