#include "sim_server/fields/field_cache.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>
#include <string>

#include "sim_server/fields/mesh_field.hpp"
#include "tests/sim_server/mesh/solids.hpp"
#include "tests/test_folder.hpp"

namespace stillgrid::fields::field_cache_test {
namespace {

constexpr collision::FieldFineness kFineness{0.09, 0.12, 0.15};

bool are_same(const collision::DistanceField& a, const collision::DistanceField& b) {
  return a.shape().bricks == b.shape().bricks && a.shape().lowest_m == b.shape().lowest_m &&
         std::ranges::equal(a.words(), b.words());
}

TEST_CASE("A kept field is the one that was made, to the bit", "[field_cache]") {
  const tests::TestFolder folder;
  const mesh::TriangleMesh mesh = mesh::capsule_mesh(0.5, 0.2, 24, 6);
  const FieldCache cache(folder.path, mesh, kFineness);
  CHECK_FALSE(cache.read());
  const collision::DistanceField made = make_mesh_field(mesh, kFineness);
  cache.write(made);
  const auto kept = cache.read();
  REQUIRE(kept);
  CHECK(are_same(*kept, made));
}

TEST_CASE("A field of another mesh or fineness is not found", "[field_cache]") {
  const tests::TestFolder folder;
  const mesh::TriangleMesh mesh = mesh::cube_mesh();
  FieldCache(folder.path, mesh, kFineness).write(make_mesh_field(mesh, kFineness));
  CHECK(FieldCache(folder.path, mesh, kFineness).read());
  for (double collision::FieldFineness::*const number :
       {&collision::FieldFineness::cell_m, &collision::FieldFineness::band_m,
        &collision::FieldFineness::margin_m}) {
    collision::FieldFineness other = kFineness;
    other.*number *= 1.0 + 1e-15;
    CHECK_FALSE(FieldCache(folder.path, mesh, other).read());
  }
  const MeasuredSurface measured{.offset_m = 0.01, .places = {{{0.5, 0.5, 1.0}, 300.0}}};
  MeasuredSurface moved = measured, stiffer = measured, of_another = measured;
  moved.offset_m *= 1.0 + 1e-15;
  stiffer.places[0].stiffness_N_per_m += 1e-12;
  of_another.own_N_per_m = 2.0;
  CHECK_FALSE(FieldCache(folder.path, mesh, kFineness, measured).read());
  FieldCache(folder.path, mesh, kFineness, measured)
      .write(make_mesh_field(mesh, kFineness, measured));
  CHECK(FieldCache(folder.path, mesh, kFineness, measured).read());
  for (const MeasuredSurface& changed : {moved, stiffer, of_another})
    CHECK_FALSE(FieldCache(folder.path, mesh, kFineness, changed).read());
  mesh::TriangleMesh other = mesh;
  other.vertices_m[5].x() += 1e-15;
  CHECK_FALSE(FieldCache(folder.path, other, kFineness).read());
}

TEST_CASE("A damaged field is as none", "[field_cache]") {
  const tests::TestFolder folder;
  const mesh::TriangleMesh mesh = mesh::cube_mesh();
  const FieldCache cache(folder.path, mesh, kFineness);
  cache.write(make_mesh_field(mesh, kFineness));
  std::ostringstream text;
  text << std::ifstream(cache.file(), std::ios::binary).rdbuf();
  const std::string whole = text.str();
  const auto write = [&](const std::string& bytes) {
    std::ofstream(cache.file(), std::ios::binary) << bytes;
  };
  // The head byte by byte, then here and there.
  for (std::size_t i = 0; i < whole.size(); i += i < 64 ? 1 : 9973) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 4);
    write(damaged);
    INFO(i);
    CHECK_FALSE(cache.read());
    write(whole.substr(0, i));
    CHECK_FALSE(cache.read());
  }
  write(whole + "x");
  CHECK_FALSE(cache.read());
  write(whole);
  CHECK(cache.read());
}

TEST_CASE("A field that cannot be kept says so", "[field_cache]") {
  const tests::TestFolder folder;
  folder.write(".stillgrid", "a file where the folder would be");
  const mesh::TriangleMesh mesh = mesh::cube_mesh();
  const FieldCache cache(folder.path, mesh, kFineness);
  CHECK_THROWS_WITH(cache.write(make_mesh_field(mesh, kFineness)),
                    Catch::Contains("cannot be written"));
}

}  // namespace
}  // namespace stillgrid::fields::field_cache_test
