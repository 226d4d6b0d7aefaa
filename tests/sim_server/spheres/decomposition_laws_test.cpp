#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "sim_server/mesh/mesh_repair.hpp"
#include "sim_server/spheres/decomposition.hpp"
#include "sim_server/spheres/decomposition_error.hpp"
#include "sim_server/spheres/sampling.hpp"
#include "sim_server/spheres/sphere_file.hpp"
#include "tests/sanitizer_cut.hpp"
#include "tests/sim_server/spheres/decomposition_checks.hpp"
#include "tests/sim_server/spheres/generated_solids.hpp"
#include "tests/test_folder.hpp"

namespace stillgrid::spheres::decomposition_laws_test {
namespace {

struct Solid {
  std::string name;
  mesh::TriangleMesh mesh;
  double tolerance_m;
  bool cuts_itself = false;
};

std::vector<Solid> solids() {
  std::vector<Solid> all;
  const auto add = [&](const char* kind, unsigned seed, const mesh::TriangleMesh& mesh,
                       double share) {
    const std::string name = std::string(kind) + " of seed " + std::to_string(seed);
    const mesh::ClosedMesh closed = mesh::make_closed(mesh, name);
    all.push_back({name, closed.mesh, share * MeshSolid(closed.mesh).size_m, closed.folds > 0});
  };
  constexpr unsigned kCutting = tests::kIsSanitized ? 2 : 4, kRound = tests::kIsSanitized ? 1 : 3;
  for (unsigned seed = 1; seed <= kCutting; ++seed)
    add("slab that cuts itself", seed, slab_mesh(seed, 12, 20, 1.6, -2.5), 0.03);
  for (const unsigned seed : {7U, 8U}) add("slab", seed, slab_mesh(seed, 12, 12, 0.4, -3.0), 0.04);
  for (unsigned seed = 1; seed <= kRound; ++seed) {
    add("box", seed, random_box(seed), 0.04);
    add("star", seed, star_mesh(seed, 0.15 * seed), 0.04);
    add("torus", seed, mesh::torus_mesh(1.0, 0.1 + 0.1 * seed, 24, 12), 0.04);
  }
  return all;
}

/// What is written is read back, to the bit; a radius that is not positive would be refused.
void check_file(const std::vector<Ball>& balls, const tests::TestFolder& folder) {
  const auto file = folder.path / "balls.csv";
  write_spheres(balls, file);
  const std::vector<Ball> read = read_spheres(file);
  REQUIRE(read.size() == balls.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    CHECK(read[i].radius_m == balls[i].radius_m);
    CHECK(read[i].centre_m == balls[i].centre_m);
  }
}

TEST_CASE("Spheres of any solid are spheres, as near as they claim, and are read back",
          "[decomposition_laws]") {
  const tests::TestFolder folder;
  int cut_themselves = 0;
  for (const Solid& solid : solids()) {
    INFO(solid.name);
    cut_themselves += solid.cuts_itself ? 1 : 0;
    const Decomposition result = decompose(solid.mesh, solid.tolerance_m);
    for (const Ball& ball : result.balls) CHECK(ball.radius_m > 0.0);
    // Where a mesh cuts itself its inside is in doubt, and a tolerance may be out of reach.
    if (!solid.cuts_itself) CHECK(result.is_reached());
    CHECK(sampled_hausdorff_m(solid.mesh, result.balls) <= result.hausdorff_m);
    check_file(result.balls, folder);
  }
  CHECK(cut_themselves >= (tests::kIsSanitized ? 1 : 2));
}

TEST_CASE("Even spheres of any solid are spheres, and are read back", "[decomposition_laws]") {
  const tests::TestFolder folder;
  for (const Solid& solid : solids()) {
    INFO(solid.name);
    const double spacing_m = 1.5 * solid.tolerance_m;
    const std::vector<Ball> balls = surface_balls(solid.mesh, spacing_m, spacing_m);
    for (const Ball& ball : balls) CHECK(ball.radius_m > 0.0);
    check_file(balls, folder);
  }
}

TEST_CASE("What no spheres can hold is held as near as they came", "[decomposition_laws]") {
  // The top of a cube turned by half a turn: its walls meet in the middle, and half of them face
  // in.
  mesh::TriangleMesh twisted = mesh::cube_mesh();
  std::swap(twisted.vertices_m[4], twisted.vertices_m[7]);
  std::swap(twisted.vertices_m[5], twisted.vertices_m[6]);
  const mesh::ClosedMesh closed = mesh::make_closed(twisted, "twisted");
  REQUIRE(closed.folds > 0);
  const Decomposition result = decompose(closed.mesh, 0.1);
  CHECK_FALSE(result.is_reached());
  CHECK(result.tolerance_m == 0.1);
  REQUIRE_FALSE(result.balls.empty());
  CHECK(sampled_hausdorff_m(closed.mesh, result.balls) <= result.hausdorff_m);
}

}  // namespace
}  // namespace stillgrid::spheres::decomposition_laws_test
