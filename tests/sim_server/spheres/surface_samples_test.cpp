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

/// A bar along y whose section is an L: a crease runs along (1, y, 1).
mesh::TriangleMesh l_bar() {
  const std::vector<Eigen::Vector2d> section{{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}};
  mesh::TriangleMesh mesh;
  for (const double y : {0.0, 5.0})
    for (const Eigen::Vector2d& corner : section)
      mesh.vertices_m.emplace_back(corner.x(), y, corner.y());
  for (int i = 0; i < 6; ++i) {
    const int next = (i + 1) % 6;
    mesh.triangles.emplace_back(i, i + 6, next);
    mesh.triangles.emplace_back(next, i + 6, next + 6);
  }
  for (const Eigen::Vector3i& end : {Eigen::Vector3i(0, 1, 3), Eigen::Vector3i(1, 2, 3),
                                     Eigen::Vector3i(0, 3, 5), Eigen::Vector3i(3, 4, 5)}) {
    mesh.triangles.push_back(end);
    mesh.triangles.emplace_back(end.z() + 6, end.y() + 6, end.x() + 6);
  }
  return mesh;
}

TEST_CASE("A crease narrower than the tool is left out, and nothing else", "[surface_samples]") {
  const mesh::TriangleMesh mesh = l_bar();
  const SurfaceSamples all = sample_surface(mesh, 20000);
  const SurfaceSamples reachable = reachable_samples(all, mesh::MeshDistance(mesh), 0.5, 0.1);
  std::size_t in_crease = 0;
  for (std::size_t i = 0; i < all.points_m.size(); ++i) {
    // Along both walls of the crease, the tool's centre is 0.4 from its own wall.
    const Eigen::Vector3d& p_m = all.points_m[i];
    const bool on_wall = (p_m.z() == Approx(1.0) && p_m.x() > 1.0 && p_m.x() < 1.39) ||
                         (p_m.x() == Approx(1.0) && p_m.z() > 1.0 && p_m.z() < 1.39);
    in_crease += on_wall && std::abs(all.normals[i].y()) < 0.5;
  }
  CHECK(in_crease > 200);
  CHECK(reachable.points_m.size() == all.points_m.size() - in_crease);
}

}  // namespace
}  // namespace stillgrid::spheres::surface_samples_test
