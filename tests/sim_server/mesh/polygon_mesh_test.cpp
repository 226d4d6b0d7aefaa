#include "sim_server/mesh/polygon_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "sim_server/mesh/mass_properties.hpp"
#include "sim_server/mesh/mesh_file.hpp"
#include "sim_server/mesh/mesh_repair.hpp"

namespace stillgrid::mesh::polygon_mesh_test {
namespace {

using Catch::Contains;
using Outline = std::vector<Eigen::Vector2d>;

double area(const Outline& outline) {
  double twice = 0.0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
    twice += a.x() * b.y() - b.x() * a.y();
  }
  return 0.5 * twice;
}

/// A prism over an outline: two faces of all its corners, and its walls.
PolygonMesh prism(const Outline& outline, double height) {
  PolygonMesh mesh{"prism", {}, {}, {}};
  const auto count = static_cast<int>(outline.size());
  for (const double z : {0.0, height})
    for (const Eigen::Vector2d& corner : outline) mesh.add_vertex(corner.x(), corner.y(), z);
  for (int i = count - 1; i >= 0; --i) mesh.add_corner(i);
  mesh.end_face();
  for (int i = 0; i < count; ++i) mesh.add_corner(count + i);
  mesh.end_face();
  for (int i = 0; i < count; ++i) {
    const int next = (i + 1) % count;
    for (const int corner : {i, next, count + next, count + i}) mesh.add_corner(corner);
    mesh.end_face();
  }
  return mesh;
}

/// Area of all triangles whose corners are of one height: that of the two faces, if they are
/// covered once.
double area_of_ends(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const auto corner = [&](int i) { return mesh.vertices_m[static_cast<std::size_t>(t[i])]; };
    if (corner(0).z() != corner(1).z() || corner(1).z() != corner(2).z()) continue;
    sum += 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm();
  }
  return sum;
}

Outline star(int points, double inner) {
  Outline outline;
  for (int i = 0; i < 2 * points; ++i) {
    const double angle = std::numbers::pi * i / points, radius = i % 2 == 0 ? 1.0 : inner;
    outline.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  return outline;
}

/// A band that winds round itself twice and a half.
Outline spiral(int steps) {
  Outline outline;
  for (int side = 0; side < 2; ++side)
    for (int k = 0; k <= steps; ++k) {
      const int i = side == 0 ? k : steps - k;
      const double angle = 5.0 * std::numbers::pi * i / steps;
      const double radius = 0.3 + 0.1 * angle + (side == 0 ? 0.2 : 0.0);
      outline.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    }
  return outline;
}

/// Corners at random radii, as seen from within.
Outline random_outline(unsigned seed, int corners) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> radius(0.1, 1.0);
  Outline outline;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / corners, length = radius(random);
    outline.emplace_back(length * std::cos(angle), length * std::sin(angle));
  }
  return outline;
}

TEST_CASE("Faces of any outline are covered once, however they lie", "[polygon_mesh]") {
  std::vector<Outline> outlines = {star(5, 0.4),
                                   star(40, 0.9),
                                   star(300, 0.2),
                                   spiral(60),
                                   {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}},
                                   {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {1, 1}, {0, 1}},
                                   {{0, 0}, {1, 0.1}, {2, 0}, {1, 2}}};
  for (unsigned seed = 1; seed <= 40; ++seed)
    outlines.push_back(random_outline(seed, 3 + static_cast<int>(seed)));
  const Eigen::Quaterniond turn(0.3, -0.5, 0.7, 0.2);
  for (const Outline& outline : outlines) {
    INFO(outline.size() << " corners");
    PolygonMesh polygons = prism(outline, 0.5);
    const TriangleMesh flat = cut_into_triangles(polygons);
    CHECK(area_of_ends(flat) == Approx(2.0 * area(outline)));
    for (Eigen::Vector3d& vertex : polygons.vertices)
      vertex = turn.normalized() * vertex + Eigen::Vector3d(3, 2, 1);
    const ClosedMesh closed = make_closed(cut_into_triangles(polygons), "prism");
    CHECK(closed.folds == 0);
    CHECK(closed.repair.turned_faces == 0);
    CHECK(mass_properties(closed.mesh).volume_m3 == Approx(0.5 * area(outline)));
    std::size_t begin = 0;  // seen from behind
    for (const std::size_t end : polygons.face_ends) {
      const auto at = [&](std::size_t i) {
        return polygons.corners.begin() + static_cast<std::ptrdiff_t>(i);
      };
      std::reverse(at(begin), at(end));
      begin = end;
    }
    CHECK(mass_properties(make_closed(cut_into_triangles(polygons), "turned").mesh).volume_m3 ==
          Approx(0.5 * area(outline)));
  }
}

TEST_CASE("A hole that a bridge joins to the outline stays a hole", "[polygon_mesh]") {
  PolygonMesh mesh{"ring", {}, {}, {}};
  for (const double half : {2.0, 1.0}) {
    mesh.add_vertex(-half, -half, 0);
    mesh.add_vertex(half, -half, 0);
    mesh.add_vertex(half, half, 0);
    mesh.add_vertex(-half, half, 0);
  }
  for (const int corner : {0, 1, 2, 3, 0, 4, 7, 6, 5, 4}) mesh.add_corner(corner);
  mesh.end_face();
  const TriangleMesh cut = cut_into_triangles(mesh);
  CHECK(cut.triangles.size() == 8);
  CHECK(area_of_ends(cut) == Approx(12.0));
}

TEST_CASE("A convex face is a fan, and a bent one is cut by its outline", "[polygon_mesh]") {
  PolygonMesh mesh{"quad", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.1}, {0, 1, 0}}, {0, 1, 2, 3}, {4}};
  const TriangleMesh cut = cut_into_triangles(mesh);
  REQUIRE(cut.triangles.size() == 2);
  CHECK(cut.triangles[0] == Eigen::Vector3i(0, 1, 2));
  CHECK(cut.triangles[1] == Eigen::Vector3i(0, 2, 3));
}

TEST_CASE("What cannot be cut is refused with the number of its face", "[polygon_mesh]") {
  // Its outline goes round twice.
  Outline pentagram;
  for (int i = 0; i < 5; ++i)
    pentagram.emplace_back(std::cos(0.8 * std::numbers::pi * i),
                           std::sin(0.8 * std::numbers::pi * i));
  CHECK_THROWS_WITH(cut_into_triangles(prism(pentagram, 1.0)),
                    Contains("prism: face 1 of 5 corners: its outline crosses itself"));
  CHECK_THROWS_WITH(cut_into_triangles(prism({{0, 0}, {2, 0}, {0, 1}, {2, 1.5}, {3, 4}}, 1.0)),
                    Contains("crosses itself"));
  PolygonMesh stray{"stray", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2, 0, 1, 3}, {3, 6}};
  CHECK_THROWS_WITH(
      cut_into_triangles(stray),
      Contains("face 2 of 3 corners: names a vertex that is none: expected one of 3"));
  PolygonMesh far{"far", {{0, 0, 0}, {1e31, 0, 0}, {0, 1, 0}}, {0, 1, 2}, {3}};
  CHECK_THROWS_WITH(cut_into_triangles(far), Contains("vertex 2"));
  CHECK_THROWS_WITH(cut_into_triangles(prism(spiral(40'000), 1.0)), Contains("too long to cut"));
}

}  // namespace
}  // namespace stillgrid::mesh::polygon_mesh_test
