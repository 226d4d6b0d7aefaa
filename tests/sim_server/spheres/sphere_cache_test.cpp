#include "sim_server/spheres/sphere_cache.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "tests/sim_server/mesh/solids.hpp"
#include "tests/test_folder.hpp"

namespace stillgrid::spheres::sphere_cache_test {
namespace {

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

TEST_CASE("Kept spheres are those that were made, to the bit", "[sphere_cache]") {
  const tests::TestFolder folder;
  const mesh::TriangleMesh mesh = mesh::capsule_mesh(0.5, 0.2, 24, 6);
  const SphereCache cache(folder.path, mesh, "tolerance_m", 0.03);
  CHECK_FALSE(cache.read());
  const Decomposition made = decompose(mesh, 0.03);
  cache.write(made);
  const auto kept = cache.read();
  REQUIRE(kept);
  REQUIRE(kept->balls.size() == made.balls.size());
  for (std::size_t i = 0; i < made.balls.size(); ++i) {
    CHECK(kept->balls[i].centre_m == made.balls[i].centre_m);
    CHECK(kept->balls[i].radius_m == made.balls[i].radius_m);
  }
  CHECK(kept->hausdorff_m == made.hausdorff_m);
  CHECK(kept->is_reached() == made.is_reached());
}

TEST_CASE("Spheres of another mesh, way or value are not found", "[sphere_cache]") {
  const tests::TestFolder folder;
  const mesh::TriangleMesh mesh = mesh::cube_mesh();
  Decomposition made;
  made.balls = {{{0.5, 0.5, 0.5}, 0.5}};
  SphereCache(folder.path, mesh, "tolerance_m", 0.1).write(made);
  CHECK(SphereCache(folder.path, mesh, "tolerance_m", 0.1).read());
  CHECK_FALSE(SphereCache(folder.path, mesh, "surface_spacing_m", 0.1).read());
  CHECK_FALSE(SphereCache(folder.path, mesh, "tolerance_m", 0.1000000001).read());
  mesh::TriangleMesh other = mesh;
  other.vertices_m[5].x() += 1e-15;
  CHECK_FALSE(SphereCache(folder.path, other, "tolerance_m", 0.1).read());
}

TEST_CASE("A damaged file is as none: each byte counts", "[sphere_cache]") {
  const tests::TestFolder folder;
  const SphereCache cache(folder.path, mesh::cube_mesh(), "tolerance_m", 0.1);
  Decomposition made;
  made.balls = {{{0.25, 0.5, 0.5}, 0.5}, {{0.75, 0.5, 0.5}, 0.25}};
  made.mesh_to_union_m = 0.125;
  made.union_to_mesh_m = 0.25;
  cache.write(made);
  const std::string whole = text_of(cache.file());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string damaged = whole;
    damaged[i] = damaged[i] == '1' ? '2' : '1';
    std::ofstream(cache.file()) << damaged;
    INFO(i);
    CHECK_FALSE(cache.read());
    std::ofstream(cache.file()) << whole.substr(0, i);
    CHECK((i + 1 == whole.size() || !cache.read()));  // the last byte ends the last line
  }
  cache.write(made);
  CHECK(cache.read());
}

TEST_CASE("What cannot be kept says so", "[sphere_cache]") {
  const tests::TestFolder folder;
  folder.write(".stillgrid", "a file where the folder would be");
  const SphereCache cache(folder.path, mesh::cube_mesh(), "tolerance_m", 0.1);
  Decomposition made;
  made.balls = {{{0.5, 0.5, 0.5}, 0.5}};
  CHECK_THROWS_WITH(cache.write(made), Catch::Contains("cannot be written"));
  CHECK_FALSE(cache.read());
}

}  // namespace
}  // namespace stillgrid::spheres::sphere_cache_test
