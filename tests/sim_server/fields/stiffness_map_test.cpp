#include "sim_server/fields/stiffness_map.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <string>

#include "shared/collision/distance_field.hpp"
#include "sim_server/fields/mesh_field.hpp"
#include "sim_server/mesh/mesh_distance.hpp"
#include "tests/sim_server/spheres/generated_solids.hpp"
#include "tests/test_folder.hpp"

namespace stillgrid::fields::stiffness_map_test {
namespace {

using Catch::Contains;
using Eigen::Vector3d;

constexpr double kOwn_N_per_m = 410.0;

struct Random {
  std::mt19937 engine;
  explicit Random(unsigned seed) : engine(seed) {}
  double in(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  Vector3d point(double size) { return {in(-size, size), in(-size, size), in(-size, size)}; }
};

/// Places on a wavy sheet, about h apart, with a stiffness of a function of place.
template <class Stiffness>
std::vector<StiffnessPlace> sheet(Random& random, double h, Stiffness&& stiffness) {
  std::vector<StiffnessPlace> places;
  for (int i = -8; i <= 8; ++i)
    for (int j = -8; j <= 8; ++j) {
      const double x = h * (i + random.in(-0.2, 0.2)), y = h * (j + random.in(-0.2, 0.2));
      const Vector3d at(x, y, 0.4 * h * std::sin(x / (3.0 * h)));
      places.push_back({at, stiffness(at)});
    }
  return places;
}

}  // namespace

TEST_CASE("A map is smooth, and nowhere beyond what goes into it", "[stiffness_map]") {
  Random random(GENERATE(range(1U, 9U)));
  const double h_m = random.in(0.002, 0.02);
  const std::vector<StiffnessPlace> places =
      sheet(random, h_m, [&](const Vector3d&) { return random.in(90.0, 1700.0); });
  const StiffnessMap map(places, kOwn_N_per_m);
  double farthest_N_per_m = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const Vector3d at_m = random.point(12.0 * h_m),
                   step_m = 1e-4 * h_m * random.point(1.0).normalized();
    const double here = map.stiffness_N_per_m(at_m);
    CHECK(here >= 90.0);
    CHECK(here <= 1700.0);
    // Differences go with the step, and their differences with its square.
    const double before = map.stiffness_N_per_m(at_m - step_m),
                 behind = map.stiffness_N_per_m(at_m + step_m);
    CHECK(std::abs(behind - before) < 1e-4 * 1700.0 * 40.0);
    CHECK(std::abs(behind + before - 2.0 * here) < 1e-8 * 1700.0 * 2e3);
    farthest_N_per_m = std::max(farthest_N_per_m, std::abs(here - kOwn_N_per_m));
  }
  CHECK(farthest_N_per_m > 400.0);
}

TEST_CASE("Among places a slope of stiffness is what was measured, beyond them the body's own",
          "[stiffness_map]") {
  Random random(GENERATE(range(1U, 9U)));
  const double h_m = random.in(0.002, 0.02);
  const Vector3d slope = Vector3d(random.in(-1.0, 1.0), random.in(-1.0, 1.0), 0.0) / (16.0 * h_m);
  const auto true_N_per_m = [&](const Vector3d& at) { return 500.0 * (1.0 + slope.dot(at)); };
  std::vector<StiffnessPlace> places = sheet(random, h_m, true_N_per_m);
  const StiffnessMap map(places, kOwn_N_per_m);
  std::ranges::shuffle(places, random.engine);
  const StiffnessMap shuffled(places, kOwn_N_per_m);
  for (int i = 0; i < 500; ++i) {
    Vector3d at_m = random.point(6.0 * h_m);
    at_m.z() = 0.4 * h_m * std::sin(at_m.x() / (3.0 * h_m));
    const double here = map.stiffness_N_per_m(at_m);
    CHECK(here == Approx(true_N_per_m(at_m)).margin(25.0));  // own weight, uneven places
    CHECK(shuffled.stiffness_N_per_m(at_m) == Approx(here).epsilon(1e-12));
  }
  for (const Vector3d& at_m :
       {Vector3d(40.0 * h_m, 0.0, 0.0), Vector3d(0.0, 0.0, 9.0 * h_m), Vector3d(-1e3, 1e3, 0.0)})
    CHECK(map.stiffness_N_per_m(at_m) == kOwn_N_per_m);
}

TEST_CASE("One place alone is the whole body's stiffness, and places may repeat",
          "[stiffness_map]") {
  const Vector3d at_m(0.01, 0.02, 0.03);
  CHECK(StiffnessMap({}, kOwn_N_per_m).stiffness_N_per_m(at_m) == kOwn_N_per_m);
  const std::vector<StiffnessPlace> one = {{at_m, 730.0}}, twice = {{at_m, 730.0}, {at_m, 770.0}};
  CHECK(StiffnessMap(one, kOwn_N_per_m).stiffness_N_per_m({5.0, -3.0, 1.0}) == 730.0);
  CHECK(StiffnessMap(twice, kOwn_N_per_m).stiffness_N_per_m({5.0, -3.0, 1.0}) == 750.0);
  // Two measurements of each place count as their mean, but for the body's own share.
  Random random(3);
  const auto places = sheet(random, 0.005, [&](const Vector3d&) { return 600.0; });
  std::vector<StiffnessPlace> doubled = places;
  for (const StiffnessPlace& place : places) doubled.push_back({place.position_m, 800.0});
  CHECK(StiffnessMap(doubled, 700.0).stiffness_N_per_m({0.001, 0.002, 0.0}) ==
        Approx(700.0).epsilon(1e-9));
}

TEST_CASE("A file of places that cannot be meant is refused with line, column and value",
          "[stiffness_map]") {
  const tests::TestFolder folder;
  const auto refusal = [&](const std::string& text) -> std::string {
    try {
      (void)read_stiffness_places(folder.write("map.csv", text));
    } catch (const std::runtime_error& error) {
      const std::string file = (folder.path / "map.csv").string();
      CHECK(std::string(error.what()).starts_with(file));
      return std::string(error.what()).substr(file.size());
    }
    return "";
  };
  const std::string header = "# fitted\nx_m,y_m,z_m,stiffness_N_per_m\n";
  CHECK(refusal(header + "0,0,-1e-3,500\r\n\n 0.1 , 2,3, 1e3") == "");
  CHECK(refusal("stiffness_N_per_m,x_mm,y_mm,z_mm\n500,0,0,-1\n") == "");
  CHECK(refusal("x,y,z,k\n0,0,0,1\n") ==
        ":1: column x_m: missing: expected x_m, y_m, z_m (or _mm), stiffness_N_per_m");
  CHECK(refusal(header + "0,0,0\n") ==
        ":3: column x_m: value '0': expected a row of 4 fields, not 3");
  CHECK(refusal(header + "0,0,0,1\n0,nan,0,1\n") ==
        ":4: column y_m: value 'nan': expected a finite number");
  CHECK(refusal(header + ",0,0,1\n") == ":3: column x_m: value '': expected a finite number");
  CHECK(refusal(header + "0,0,1e300,1\n") ==
        ":3: column z_m: value '1e300': expected a length of at most 1e6 m");
  for (const std::string value : {"0", "-5", "inf", "5 N/m", "0x10"})
    CHECK(refusal(header + "0,0,0," + value + "\n")
              .starts_with(":3: column stiffness_N_per_m: value '" + value + "': expected a "));
  CHECK(refusal(header) == ": 0 places: expected one at least");
  std::string many = header;
  for (std::size_t i = 0; i <= kMaxStiffnessPlaces; ++i) many += "0,0,0,1\n";
  CHECK(refusal(many) == ":100003: column stiffness_N_per_m: expected at most 100000 places");
  CHECK_THROWS_WITH(read_stiffness_places("/nowhere/a.csv"),
                    Contains("/nowhere/a.csv: cannot be read"));
}

TEST_CASE("A mesh's field is as stiff as its map, and as far out as its offset",
          "[stiffness_map]") {
  const unsigned seed = GENERATE(range(1U, 7U));
  Random random(seed);
  const mesh::TriangleMesh solid = spheres::star_mesh(seed, 0.3);
  MeasuredSurface measured{.offset_m = random.in(-0.03, 0.03), .own_N_per_m = kOwn_N_per_m};
  for (const Vector3d& vertex_m : solid.vertices_m)
    measured.places.push_back({vertex_m, 500.0 + 300.0 * std::sin(2.0 * vertex_m.x())});
  const collision::FieldFineness fineness{0.03, 0.1, 0.2};
  const collision::DistanceField plain = make_mesh_field(solid, fineness),
                                 field = make_mesh_field(solid, fineness, measured);
  const StiffnessMap map(measured.places, kOwn_N_per_m);
  const mesh::MeshDistance exact(solid);
  CHECK(field.shape().has_stiffness == 1);
  CHECK(plain.shape().has_stiffness == 0);
  for (const Vector3d& vertex_m : solid.vertices_m) {
    const Vector3d at_m = vertex_m + random.point(0.05);
    const auto found = collision::sample(field.view(), at_m);
    const auto without = collision::sample(plain.view(), at_m);
    REQUIRE(found);
    REQUIRE(without);
    // Another grid: each errs by less than a cell at an edge, and the map is sampled once a brick.
    CHECK(found->distance_m == Approx(without->distance_m - measured.offset_m).margin(0.03));
    CHECK(found->stiffness_scale ==
          Approx(map.stiffness_N_per_m(exact.closest(at_m).point_m) / kOwn_N_per_m).margin(0.12));
  }
}

}  // namespace stillgrid::fields::stiffness_map_test
