#include "sim_server/spheres/decomposition.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/sim_server/mesh/solids.hpp"
#include "tests/sim_server/spheres/decomposition_checks.hpp"

namespace stillgrid::spheres::decomposition_test {
namespace {

TEST_CASE("A ball is one sphere, of next to no error", "[decomposition]") {
  const Decomposition result = decompose(mesh::ball_mesh(1.0, 24, 6), 0.03);
  REQUIRE(result.balls.size() == 1);
  CHECK(result.balls[0].centre_m.norm() < 0.03);
  CHECK(result.balls[0].radius_m == Approx(1.0).margin(0.03));
}

TEST_CASE("A cube takes fewer than greedy balls inside it, and has no hollow", "[decomposition]") {
  const Decomposition result = decompose(mesh::cube_mesh(), 0.05);
  CHECK(result.balls.size() < 185);
  check_decomposition(mesh::cube_mesh(), result, 0.05);
}

TEST_CASE("A slot narrower than the tolerance is not filled", "[decomposition]") {
  // A tuning fork: two bars 0.03 apart on a foot.
  const mesh::TriangleMesh mesh = [] {
    mesh::TriangleMesh fork;
    const double outline[8][2] = {{0, 0},       {1, 0},       {1, 1},     {0.515, 1},
                                  {0.515, 0.3}, {0.485, 0.3}, {0.485, 1}, {0, 1}};
    for (int side = 0; side < 2; ++side)
      for (const auto& corner : outline)
        fork.vertices_m.push_back({corner[0], corner[1], 0.4 * side});
    for (int i = 0; i < 8; ++i) {
      const int next = (i + 1) % 8;
      fork.triangles.push_back({i, next, 8 + next});
      fork.triangles.push_back({i, 8 + next, 8 + i});
    }
    const int top[6][3] = {{0, 5, 7}, {5, 6, 7}, {0, 1, 5}, {1, 4, 5}, {1, 2, 4}, {2, 3, 4}};
    for (const auto& t : top) {
      fork.triangles.push_back({8 + t[0], 8 + t[1], 8 + t[2]});
      fork.triangles.push_back({t[0], t[2], t[1]});
    }
    return fork;
  }();
  const Decomposition result = decompose(mesh, 0.06);
  CHECK(result.hausdorff_m <= 0.06);
  // Had balls closed the slot, its bottom would be 0.7 from the union's surface.
  int open = 0;
  for (int i = 0; i <= 60; ++i)
    open += outside_all_m(result.balls, {0.5, 0.35 + 0.01 * i, 0.2}) > 0.0;
  CHECK(open > 0);
}

TEST_CASE("The same mesh gives the same spheres, to the bit", "[decomposition]") {
  const mesh::TriangleMesh mesh = mesh::capsule_mesh(0.5, 0.2, 24, 6);
  const Decomposition first = decompose(mesh, 0.03), again = decompose(mesh, 0.03);
  REQUIRE(first.balls.size() == again.balls.size());
  for (std::size_t i = 0; i < first.balls.size(); ++i) {
    CHECK(first.balls[i].centre_m == again.balls[i].centre_m);
    CHECK(first.balls[i].radius_m == again.balls[i].radius_m);
  }
}

TEST_CASE("A tolerance that cannot be met is refused with the least", "[decomposition]") {
  CHECK_THROWS_WITH(decompose(mesh::cube_mesh(), 1e-5),
                    Catch::Contains("value 1e-05 m: expected at least 1/5000"));
  CHECK_THROWS_AS(decompose(mesh::cube_mesh(), -1.0), std::invalid_argument);
  CHECK_THROWS_AS(decompose(mesh::cube_mesh(), std::nan("")), std::invalid_argument);
}

}  // namespace
}  // namespace stillgrid::spheres::decomposition_test
