#include "sim_server/fields/mesh_field.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <random>

#include "sim_server/mesh/mesh_distance.hpp"
#include "sim_server/mesh/mesh_file.hpp"
#include "sim_server/mesh/mesh_repair.hpp"
#include "sim_server/spheres/surface_samples.hpp"
#include "tests/sim_server/spheres/generated_solids.hpp"

namespace stillgrid::fields::mesh_field_test {
namespace {

using Eigen::Vector3d;

/// By which the tip of a cone is blunted, in cells: the mean distance over a quadratic B-spline.
constexpr double kBlunt = 0.8;

/// Of the solid's longest side.
collision::FieldFineness fineness_of(const mesh::TriangleMesh& solid, double cell, double band,
                                     double margin) {
  const double side_m = box_of(solid).sizes().maxCoeff();
  return {cell * side_m, band * side_m, margin * side_m};
}

struct Random {
  std::mt19937 engine;
  explicit Random(unsigned seed) : engine(seed) {}
  double in(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  Vector3d in_box(const Eigen::AlignedBox3d& box, double margin_m) {
    Vector3d point_m;
    for (int i = 0; i < 3; ++i) point_m[i] = in(box.min()[i] - margin_m, box.max()[i] + margin_m);
    return point_m;
  }
};

mesh::TriangleMesh solid_of(unsigned seed) {
  if (seed % 3 == 0) return spheres::random_box(seed);
  if (seed % 3 == 1) return spheres::star_mesh(seed, 0.3);
  return spheres::slab_mesh(seed, 9, 7, 0.5, -3.0);
}

/// The worst error over points within the band, in cells.
double worst_error(const mesh::TriangleMesh& solid, const collision::FieldFineness& fineness,
                   unsigned seed, std::size_t count) {
  const mesh::MeshDistance exact(solid);
  const collision::DistanceField field = make_mesh_field(solid, fineness);
  Random random(seed);
  const spheres::SurfaceSamples surface = spheres::sample_surface(solid, count);
  double worst_m = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3d at_m =
        surface.points_m[i] + random.in(-fineness.band_m, fineness.band_m) * surface.normals[i];
    const auto found = collision::sample(field.view(), at_m);
    REQUIRE(found);
    worst_m = std::max(worst_m, std::abs(found->distance_m - exact.signed_distance_m(at_m)));
  }

  return worst_m / fineness.cell_m;
}

}  // namespace

TEST_CASE("A field errs by less than a cell, at whatever edge", "[mesh_field]") {
  const unsigned seed = GENERATE(range(1U, 13U));
  const mesh::TriangleMesh solid = solid_of(seed);
  CHECK(worst_error(solid, fineness_of(solid, 0.031, 0.07, 0.11), seed, 3000) < kBlunt);
}

TEST_CASE("Default cells follow from tool, thickness and size, and stay within a bound of memory",
          "[mesh_field]") {
  const auto cell_m = [](const Vector3d& size_m, double tool_m) {
    return default_cell_m(mesh::box_mesh(Vector3d::Zero(), size_m), tool_m, tool_m, tool_m);
  };
  CHECK(cell_m({0.1, 0.1, 0.1}, 0.004) == Approx(0.002));
  CHECK(cell_m({0.1, 0.1, 0.1}, 0.05) == Approx(0.1 / 32.0));
  CHECK(cell_m({0.1, 0.1, 0.002}, 0.004) == Approx(0.001).epsilon(0.05));
  // A tool of 1 mm on a body of 1 m asks for more than the bound.
  const mesh::TriangleMesh large = mesh::box_mesh(Vector3d::Zero(), {1.0, 0.7, 0.4});
  const double tool_m = 0.001, wide_m = default_cell_m(large, tool_m, tool_m, tool_m);
  const auto field =
      make_mesh_field(large, {wide_m, std::max(tool_m, wide_m), tool_m + 4.0 * wide_m});
  CHECK(static_cast<double>(field.bytes()) < kDefaultFieldBytes);
  CHECK(static_cast<double>(field.bytes()) > 0.5 * kDefaultFieldBytes);
}

TEST_CASE("A field of a real mesh errs by less than a cell", "[mesh_field]") {
  const char* const named = std::getenv("STILLGRID_DATA");
  const std::filesystem::path folder =
      (named ? std::filesystem::path(named)
             : std::filesystem::path(STILLGRID_SOURCE_DIR) / ".." / "shared" / "data") /
      "meshes";
  const std::string name = GENERATE(as<std::string>{}, "npm_bunny.off", "mujoco_spot.obj",
                                    "sofa_liver-smooth.obj", "sofa_torus.obj");
  if (!std::filesystem::exists(folder / name)) {
    WARN("skipped: no " << (folder / name));
    return;
  }
  const mesh::TriangleMesh solid =
      mesh::make_closed(mesh::load_mesh(folder / name, 1.0), name).mesh;
  // The liver's mesh pierces itself in six places, where its exact distance jumps.
  CHECK(worst_error(solid, fineness_of(solid, 0.013, 0.03, 0.03), 5, 4000) <
        (name.starts_with("sofa_liver") ? 1.5 : kBlunt));
}

TEST_CASE("Over a face, farther than three cells from its edges, a field is exact",
          "[mesh_field]") {
  const unsigned seed = GENERATE(1U, 2U, 3U, 4U, 5U);
  const mesh::TriangleMesh box = spheres::random_box(seed);
  const collision::FieldFineness fineness = fineness_of(box, 0.017, 0.03, 0.06);
  const collision::DistanceField field = make_mesh_field(box, fineness);
  const spheres::SurfaceSamples surface = spheres::sample_surface(box, 2000);
  // In the box's own frame: its corners 0, 1, 2 and 4 span it.
  const Vector3d& corner_m = box.vertices_m[0];
  int tried = 0;
  for (std::size_t i = 0; i < surface.points_m.size(); ++i) {
    const double out_m = (static_cast<double>(i % 7) / 7.0) * fineness.band_m;
    bool is_inner = true;
    for (const std::size_t other : {1U, 2U, 4U}) {
      const Vector3d side_m = box.vertices_m[other] - corner_m;
      if (std::abs(side_m.normalized().dot(surface.normals[i])) > 0.5) continue;
      const double along_m = (surface.points_m[i] - corner_m).dot(side_m.normalized());
      is_inner = is_inner && along_m > 4.5 * fineness.cell_m &&
                 along_m < side_m.norm() - 4.5 * fineness.cell_m;
    }
    if (!is_inner) continue;
    ++tried;
    const auto found =
        collision::sample(field.view(), surface.points_m[i] + out_m * surface.normals[i]);
    REQUIRE(found);
    CHECK(std::abs(found->distance_m - out_m) < 1e-6);
    CHECK((found->gradient - surface.normals[i]).norm() < 1e-4);
  }
  CHECK(tried > 100);
}

TEST_CASE("From however deep inside, a field leads out", "[mesh_field]") {
  const unsigned seed = GENERATE(range(1U, 10U));
  const mesh::TriangleMesh solid = solid_of(seed);
  const collision::FieldFineness fineness = fineness_of(solid, 0.037, 0.05, 0.2);
  const collision::DistanceField field = make_mesh_field(solid, fineness);
  const mesh::MeshDistance exact(solid);
  Random random(seed);
  int inside = 0;
  for (int i = 0; i < 2000; ++i) {
    Vector3d at_m = random.in_box(box_of(solid), 0.0);
    if (exact.signed_distance_m(at_m) > -fineness.cell_m) continue;
    ++inside;
    int steps = 0;
    for (; steps < 400; ++steps) {
      const auto contact = collision::field_contact(field.view(), at_m, 0.0);
      REQUIRE(contact);
      if (contact->depth_m < 0.0) break;
      at_m += 0.25 * fineness.cell_m * contact->normal;
    }
    CHECK(exact.signed_distance_m(at_m) > -0.6 * fineness.cell_m);
    CHECK(steps < 400);
  }
  CHECK(inside > 20);
}

TEST_CASE("A plate thinner than a cell is as hard as a thick one to what is not", "[mesh_field]") {
  const unsigned seed = GENERATE(1U, 2U, 3U, 4U);
  Random random(seed);
  const double cell_m = 0.0013, thick_m = random.in(0.1, 0.9) * cell_m, tool_m = 5.0 * cell_m;
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(random.in(0.0, 3.0),
                        Vector3d(random.in(0, 1), random.in(0, 1), 1.0).normalized())
          .toRotationMatrix();
  const mesh::TriangleMesh plate = mesh::moved(mesh::box_mesh({0, 0, 0}, {0.05, 0.04, thick_m}),
                                               turn, Vector3d(0.01, 0.02, -0.01));
  const collision::DistanceField field = make_mesh_field(plate, {cell_m, tool_m, tool_m});
  for (int i = 0; i < 300; ++i) {
    const bool is_above = i % 2 == 0;
    const double depth_m = random.in(0.01, 1.5) * cell_m;
    const double z_m = is_above ? thick_m + tool_m - depth_m : depth_m - tool_m;
    const Vector3d at_m = turn * Vector3d(random.in(0.01, 0.04), random.in(0.01, 0.03), z_m) +
                          Vector3d(0.01, 0.02, -0.01);
    const auto contact = collision::field_contact(field.view(), at_m, tool_m);
    REQUIRE(contact);
    CHECK(contact->depth_m == Approx(depth_m).margin(1e-6));
    CHECK(contact->normal.dot(turn.col(2)) == Approx(is_above ? 1.0 : -1.0));
  }
}

TEST_CASE("Outside of a mesh's box no point is inside, even of a mesh that cuts itself",
          "[mesh_field]") {
  const unsigned seed = GENERATE(1U, 2U, 3U);
  const mesh::TriangleMesh solid = spheres::slab_mesh(seed, 8, 6, 0.7, seed == 3U ? 0.0 : -2.0);
  const collision::FieldFineness fineness = fineness_of(solid, 0.03, 0.05, 0.3);
  const collision::DistanceField field = make_mesh_field(solid, fineness);
  Random random(seed);
  const Eigen::AlignedBox3d box = box_of(solid);
  int outside = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vector3d at_m = random.in_box(box, fineness.margin_m);
    const double beyond_m = box.exteriorDistance(at_m);
    if (beyond_m < 3.0 * fineness.cell_m) continue;
    ++outside;
    const auto found = collision::sample(field.view(), at_m);
    REQUIRE(found);  // the margin is within the field
    CHECK(found->distance_m > beyond_m - 4.0 * fineness.cell_m);
  }
  CHECK(outside > 500);
}

TEST_CASE("The same mesh has the same field, to the bit", "[mesh_field]") {
  const mesh::TriangleMesh solid = spheres::star_mesh(4, 0.2);
  const collision::FieldFineness fineness = fineness_of(solid, 0.04, 0.05, 0.05);
  const auto once = make_mesh_field(solid, fineness), again = make_mesh_field(solid, fineness);
  CHECK(std::ranges::equal(once.words(), again.words()));
}

TEST_CASE("A field that would take too much is refused, before its time is spent", "[mesh_field]") {
  const mesh::TriangleMesh solid = spheres::star_mesh(4, 0.2);
  CHECK_THROWS_WITH(make_mesh_field(solid, fineness_of(solid, 0.0002, 0.01, 0.01)),
                    Catch::Contains("expected at most 256 MiB"));
  CHECK_THROWS_WITH(make_mesh_field(solid, fineness_of(solid, 0.001, 0.2, 0.01)),
                    Catch::Contains("expected at most 256 MiB"));
}

}  // namespace stillgrid::fields::mesh_field_test
