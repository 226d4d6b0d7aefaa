#include "sim_server/spheres/surface_samples.hpp"

#include <catch2/catch.hpp>

namespace stillgrid::spheres::surface_samples_test {
namespace {

/// Two rectangles that share an edge, of areas 1 and 3, in the planes z = 0 and x = 1; the second's
/// triangles are of different sizes.
mesh::TriangleMesh corner() {
  return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 0, 3}, {1, 1, 3}, {1, 0.25, 3}},
          {{0, 1, 2}, {0, 2, 3}, {1, 4, 6}, {1, 6, 2}, {2, 6, 5}}};
}

TEST_CASE("Each part of a surface has samples by its area", "[surface_samples]") {
  const SurfaceSamples samples = sample_surface(corner(), 4000);
  REQUIRE(samples.points_m.size() == 4000);
  REQUIRE(samples.normals.size() == 4000);
  int lower = 0, left = 0, low = 0;
  for (std::size_t i = 0; i < 4000; ++i) {
    const Eigen::Vector3d& point_m = samples.points_m[i];
    const bool on_first = samples.normals[i].z() == Approx(1.0);
    CHECK((on_first ? point_m.z() : point_m.x() - 1.0) == Approx(0.0).margin(1e-12));
    CHECK(samples.normals[i].norm() == Approx(1.0));
    lower += on_first;
    left += point_m.x() < 0.5;
    low += point_m.z() > 1.5;
  }
  CHECK(std::abs(lower - 1000) <= 1);
  CHECK(std::abs(left - 500) <= 10);  // of half a rectangle; strewn at random +-22
  CHECK(std::abs(low - 1500) <= 10);  // +-31
}

TEST_CASE("Few samples are still spread over all", "[surface_samples]") {
  CHECK(sample_surface(corner(), 1).points_m.size() == 1);
  const SurfaceSamples samples = sample_surface(corner(), 4);
  REQUIRE(samples.points_m.size() == 4);
  CHECK(samples.normals[0].z() == Approx(1.0));
  CHECK(samples.normals[1].z() == Approx(0.0).margin(1e-12));
}

}  // namespace
}  // namespace stillgrid::spheres::surface_samples_test
