#include "sim_server/mesh/mesh_distance.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <random>

#include "tests/sim_server/mesh/solids.hpp"

namespace stillgrid::mesh::mesh_distance_test {
namespace {

/// The nearest point of a triangle by searching its three corners, edges and plane in turn.
double distance_to_triangle_m(const TriangleMesh& mesh, const Eigen::Vector3i& triangle,
                              const Eigen::Vector3d& p) {
  Eigen::Matrix3d corners;
  for (int k = 0; k < 3; ++k)
    corners.col(k) = mesh.vertices_m[static_cast<std::size_t>(triangle[k])];
  double least_m = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d a = corners.col(k), edge = corners.col((k + 1) % 3) - a;
    const double t = std::clamp((p - a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    least_m = std::min(least_m, (a + t * edge - p).norm());
  }
  Eigen::Matrix<double, 3, 2> edges;
  edges << corners.col(1) - corners.col(0), corners.col(2) - corners.col(0);
  const Eigen::Vector2d weights =
      (edges.transpose() * edges).ldlt().solve(edges.transpose() * (p - corners.col(0)));
  if (weights.minCoeff() >= 0.0 && weights.sum() <= 1.0)
    least_m = std::min(least_m, (corners.col(0) + edges * weights - p).norm());
  return least_m;
}

/// How often the surface winds round a point: solid angles summed [Van Oosterom and Strackee 1983].
double winding(const TriangleMesh& mesh, const Eigen::Vector3d& p) {
  double angle = 0.0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices_m[static_cast<std::size_t>(t[0])] - p;
    const Eigen::Vector3d b = mesh.vertices_m[static_cast<std::size_t>(t[1])] - p;
    const Eigen::Vector3d c = mesh.vertices_m[static_cast<std::size_t>(t[2])] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle += 2.0 * std::atan2(a.dot(b.cross(c)),
                              la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle / (4.0 * std::numbers::pi);
}

/// A box whose roof is a deep valley: at its edges and corners face normals give wrong signs.
TriangleMesh notched() {
  TriangleMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1});
  mesh.vertices_m.push_back({0.5, 0.5, 0.1});
  std::erase_if(mesh.triangles, [](const Eigen::Vector3i& t) { return t.minCoeff() >= 4; });
  for (const auto& [a, b] : {std::pair(4, 5), {5, 7}, {7, 6}, {6, 4}})
    mesh.triangles.push_back({a, b, 8});
  return mesh;
}

TEST_CASE("Signed distance agrees with the nearest of all triangles and with winding",
          "[mesh_distance]") {
  const double scale = GENERATE(1e-4, 1.0, 60.0);
  const Eigen::Vector3d by_m = GENERATE(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(300, -200, 100));
  const auto shape = GENERATE(0, 1, 2);
  const TriangleMesh mesh = moved(shape == 0   ? notched()
                                  : shape == 1 ? torus_mesh(1.0, 0.3, 24, 12)
                                               : capsule_mesh(1.0, 0.2, 16, 4),
                                  scale * Eigen::Matrix3d::Identity(), by_m);
  const MeshDistance distance(mesh);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-1.5, 1.5);

  for (int i = 0; i < 300; ++i) {
    Eigen::Vector3d point_m =
        scale * Eigen::Vector3d(place(random), place(random), place(random)) + by_m;
    // A third of the points: near an edge or a corner.
    if (i % 3 == 0)
      point_m = mesh.vertices_m[static_cast<std::size_t>(i) % mesh.vertices_m.size()] +
                0.02 * (point_m - by_m);
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3i& t : mesh.triangles)
      nearest_m = std::min(nearest_m, distance_to_triangle_m(mesh, t, point_m));
    const double signed_m = distance.signed_distance_m(point_m);

    REQUIRE(std::abs(signed_m) ==
            Approx(nearest_m).epsilon(1e-9).margin(1e-12 * (by_m.norm() + scale)));
    if (nearest_m > 1e-6 * scale) REQUIRE((signed_m < 0.0) == (winding(mesh, point_m) > 0.5));
  }
}

TEST_CASE("The nearest point is found on slivers too, whose plane rounding leaves in doubt",
          "[mesh_distance]") {
  // A vertex almost on an edge of the cube: where the cube is far from the origin, or on it.
  const double off_m = GENERATE(0.0, 1e-9, 1e-6, 1e-3);
  TriangleMesh mesh = cube_mesh();
  mesh.vertices_m.push_back({0.5, off_m, off_m});
  mesh.triangles[1] = {0, 3, 8};
  mesh.triangles.push_back({8, 3, 1});
  mesh.triangles.push_back({0, 8, 1});
  mesh = moved(
      mesh, 0.01 * Eigen::AngleAxisd(1.0, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix(),
      {300, -200, 100});
  const MeshDistance distance(mesh);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-0.02, 0.02);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d point_m =
        mesh.vertices_m[8] + Eigen::Vector3d(place(random), place(random), place(random));
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3i& t : mesh.triangles)
      nearest_m = std::min(nearest_m, distance_to_triangle_m(mesh, t, point_m));
    REQUIRE(std::abs(distance.signed_distance_m(point_m)) == Approx(nearest_m).margin(1e-12));
  }
}

TEST_CASE("The nearest point lies on its triangle, with a unit normal that faces out",
          "[mesh_distance]") {
  const MeshDistance distance(cube_mesh());
  const NearestPoint above = distance.closest({0.3, 0.4, 1.5});
  CHECK((above.point_m - Eigen::Vector3d(0.3, 0.4, 1.0)).norm() < 1e-15);
  CHECK((above.normal - Eigen::Vector3d::UnitZ()).norm() < 1e-15);
  CHECK((above.triangle == 2 || above.triangle == 3));
  const NearestPoint corner = distance.closest({2, 2, 2});
  CHECK((corner.point_m - Eigen::Vector3d(1, 1, 1)).norm() < 1e-15);
  CHECK((corner.normal - Eigen::Vector3d(1, 1, 1).normalized()).norm() < 1e-12);
}

TEST_CASE("Every triangle within reach is named", "[mesh_distance]") {
  const TriangleMesh mesh = torus_mesh(1.0, 0.3, 24, 12);
  const MeshDistance distance(mesh);
  const Eigen::Vector3d point_m(1.1, 0.2, 0.3);
  const std::vector<int> near = distance.triangles_near(point_m, 0.4);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    if (distance_to_triangle_m(mesh, mesh.triangles[i], point_m) < 0.4)
      CHECK(std::binary_search(near.begin(), near.end(), static_cast<int>(i)));
  CHECK(near.size() < mesh.triangles.size());
}

}  // namespace
}  // namespace stillgrid::mesh::mesh_distance_test
