#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid {
namespace {

/// A sheet of 8 x 8 nodes, 20 mm apart, of 2 g each, hanging down from where it is pinned.
BodyDescription hanging_cloth(std::vector<int> pinned) {
  BodyDescription body = sheet({8, 8}, 0.02, 0.002, 500.0);
  body.orientation = Eigen::AngleAxisd(0.5 * std::acos(-1.0), Eigen::Vector3d::UnitX());
  body.position_m.z() = -0.07;  // the upper edge at height 0
  body.spheres = {0.02, 1e-4};
  body.pinned_nodes = std::move(pinned);
  return body;
}

TEST_CASE("A cloth pinned along its top hangs as eight chains", "[known_answers]") {
  Simulation simulation(
      scene_of({hanging_cloth({56, 57, 58, 59, 60, 61, 62, 63})}, {}, {0, 0, -9.81}));

  REQUIRE(advance(simulation, 10.0, 10));  // steps so long that little but statics is left

  for (std::size_t i = 0; i < 8; ++i)
    CHECK(simulation.world().nodes[i].position_m.z() == Approx(-0.14109872).epsilon(1e-9));
}

TEST_CASE("A cloth pinned at two corners comes to the one state of least energy",
          "[known_answers]") {
  struct Case {
    double structural, shear, bend;  // N/m
    double energy_J, mean_m, lowest_m;
  };
  const Case known =
      GENERATE(Case{500, 250, 50, -0.08898932377445, -0.0717191791594, -0.1419600196581},
               Case{5000, 2500, 500, -0.0880091398831, -0.0701774331113, NAN});
  BodyDescription body = hanging_cloth({56, 63});
  body.structural_stiffness_N_m = known.structural;
  body.shear_stiffness_N_m = known.shear;
  body.bend_stiffness_N_m = known.bend;
  Simulation simulation(scene_of({body}, {}, {0, 0, -9.81}));

  REQUIRE(advance(simulation, 0.05, 100));
  REQUIRE(advance(simulation, 1.0, 100));

  double mean_m = 0.0, lowest_m = 0.0;
  for (const Node& node : simulation.world().nodes) {
    mean_m += node.position_m.z() / 64.0;
    lowest_m = std::min(lowest_m, node.position_m.z());
  }
  CHECK(mechanical_energy_J(simulation.world()) == Approx(known.energy_J).epsilon(1e-9));
  CHECK(mean_m == Approx(known.mean_m).epsilon(1e-7));
  if (std::isfinite(known.lowest_m)) CHECK(lowest_m == Approx(known.lowest_m).epsilon(1e-7));
}

}  // namespace
}  // namespace stillgrid
