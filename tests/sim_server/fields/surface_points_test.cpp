#include "sim_server/fields/surface_points.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "sim_server/mesh/mass_properties.hpp"
#include "sim_server/mesh/mesh_distance.hpp"
#include "sim_server/spheres/surface_samples.hpp"
#include "tests/sim_server/spheres/generated_solids.hpp"

namespace stillgrid::fields::surface_points_test {
namespace {

using Eigen::Vector3d;

double to_nearest_m(const std::vector<spheres::Ball>& points, const Vector3d& place_m) {
  double least_m = std::numeric_limits<double>::infinity();
  for (const spheres::Ball& point : points)
    least_m = std::min(least_m, (point.centre_m - place_m).norm() - point.radius_m);
  return least_m;
}

TEST_CASE("Points lie within, touch the surface, and leave no wide gap", "[surface_points]") {
  const unsigned seed = GENERATE(1U, 2U, 3U, 4U);
  const mesh::TriangleMesh solid =
      seed % 2 == 0 ? spheres::random_box(seed) : spheres::star_mesh(seed, 0.25);
  constexpr std::size_t kMaxPoints = 300;
  const double spacing_m = std::sqrt(mesh::surface_area_m2(solid) / kMaxPoints);
  const auto points = surface_points(solid, kMaxPoints);
  CHECK(points.size() > kMaxPoints / 2);
  const mesh::MeshDistance distance(solid);
  int inside = 0;
  for (const spheres::Ball& point : points) {
    CHECK(point.radius_m > 0.0);
    CHECK(point.radius_m < 0.05 * spacing_m);
    const double out_m = distance.signed_distance_m(point.centre_m);
    CHECK(out_m < 1e-12);
    inside += out_m < -0.2 * point.radius_m ? 1 : 0;
    CHECK(std::abs(distance.signed_distance_m(point.centre_m)) <= 1.000001 * point.radius_m);
  }
  CHECK(inside > 0.8 * static_cast<double>(points.size()));
  for (const Vector3d& place_m : spheres::sample_surface(solid, 700).points_m)
    CHECK(to_nearest_m(points, place_m) < 1.5 * spacing_m);
}

TEST_CASE("A box has a point at each corner, and along each edge", "[surface_points]") {
  const mesh::TriangleMesh box = spheres::random_box(GENERATE(5U, 6U, 7U));
  const auto points = surface_points(box, 400);
  for (const Vector3d& corner_m : box.vertices_m) CHECK(to_nearest_m(points, corner_m) < 1e-12);
  const double spacing_m = std::sqrt(mesh::surface_area_m2(box) / 400);
  // The edges of box_mesh() join corners whose numbers differ in one digit.
  for (std::size_t a = 0; a < 8; ++a)
    for (std::size_t b : {a | 1U, a | 2U, a | 4U}) {
      if (a == b) continue;
      for (double t = 0.05; t < 1.0; t += 0.1) {
        const Vector3d on_edge_m = (1.0 - t) * box.vertices_m[a] + t * box.vertices_m[b];
        CHECK(to_nearest_m(points, on_edge_m) < 1.1 * spacing_m);
      }
    }
}

TEST_CASE("A thin plate has points on both of its sides", "[surface_points]") {
  const mesh::TriangleMesh plate = mesh::box_mesh({0, 0, 0}, {1.0, 0.8, 0.001});
  const auto points = surface_points(plate, 300);
  const auto above = std::count_if(points.begin(), points.end(), [](const spheres::Ball& point) {
    return point.centre_m.z() > 0.0005;
  });
  CHECK(above > 80);
  CHECK(static_cast<std::ptrdiff_t>(points.size()) - above > 80);
}

TEST_CASE("The same mesh has the same points", "[surface_points]") {
  const mesh::TriangleMesh solid = spheres::star_mesh(9, 0.2);
  const auto once = surface_points(solid, 200), again = surface_points(solid, 200);
  REQUIRE(once.size() == again.size());
  for (std::size_t i = 0; i < once.size(); ++i) CHECK(once[i].centre_m == again[i].centre_m);
}

}  // namespace
}  // namespace stillgrid::fields::surface_points_test
