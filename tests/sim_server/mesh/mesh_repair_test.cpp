#include "sim_server/mesh/mesh_repair.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "sim_server/mesh/mass_properties.hpp"
#include "sim_server/mesh/mesh_file.hpp"
#include "tests/sim_server/mesh/solids.hpp"

namespace stillgrid::mesh::mesh_repair_test {
namespace {

using Catch::Contains;

/// Every triangle with vertices of its own, as STL files have them.
TriangleMesh soup(const TriangleMesh& mesh) {
  TriangleMesh result;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const int first = static_cast<int>(result.vertices_m.size());
    for (const int vertex : t)
      result.vertices_m.push_back(mesh.vertices_m[static_cast<std::size_t>(vertex)]);
    result.triangles.push_back({first, first + 1, first + 2});
  }
  return result;
}

double volume_m3(const ClosedMesh& closed) {
  return mass_properties(closed.mesh).volume_m3;
}

TEST_CASE("A closed mesh is left as it is", "[mesh_repair]") {
  const ClosedMesh closed = make_closed(cube_mesh(), "cube");
  CHECK(closed.mesh.triangles.size() == 12);
  CHECK(closed.components == 1);
  CHECK(closed.folds == 0);
  const MeshRepair& done = closed.repair;
  CHECK(done.welded_vertices + done.degenerate_faces + done.doubled_faces + done.turned_faces +
            done.turned_components + done.split_vertices ==
        0);
}

TEST_CASE("Vertices at one place are joined", "[mesh_repair]") {
  TriangleMesh mesh = soup(cube_mesh());
  for (std::size_t i = 0; i < mesh.vertices_m.size(); i += 2) mesh.vertices_m[i].x() += 5e-7;
  const ClosedMesh closed = make_closed(mesh, "soup");
  CHECK(closed.repair.welded_vertices == 28);
  CHECK(closed.mesh.vertices_m.size() == 8);
  CHECK(volume_m3(closed) == Approx(1.0));
}

TEST_CASE("Degenerate and doubled faces are dropped", "[mesh_repair]") {
  TriangleMesh mesh = cube_mesh();
  mesh.triangles.push_back({3, 3, 5});
  for (int i = 0; i < 12; ++i)
    mesh.triangles.push_back(mesh.triangles[static_cast<std::size_t>(i)]);
  std::swap(mesh.triangles[20][0], mesh.triangles[20][1]);
  const ClosedMesh closed = make_closed(mesh, "doubled");
  CHECK(closed.repair.degenerate_faces == 1);
  CHECK(closed.repair.doubled_faces == 12);
  CHECK(volume_m3(closed) == Approx(1.0));
}

TEST_CASE("Faces that face the wrong way are turned, and so is what is inside out",
          "[mesh_repair]") {
  TriangleMesh mesh = cube_mesh();
  for (const std::size_t i : {2U, 5U, 7U}) std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
  const ClosedMesh some = make_closed(mesh, "some");
  CHECK(some.repair.turned_faces == 3);
  CHECK(some.repair.turned_components == 0);
  CHECK(volume_m3(some) == Approx(1.0));

  const ClosedMesh all = make_closed(inside_out(cube_mesh()), "all");
  CHECK(all.repair.turned_faces == 0);
  CHECK(all.repair.turned_components == 1);
  CHECK(volume_m3(all) == Approx(1.0));
}

TEST_CASE("Each of several pieces faces out, and a cavity faces in", "[mesh_repair]") {
  const TriangleMesh outer = cube_mesh(), inner = box_mesh({0.2, 0.2, 0.2}, {0.4, 0.4, 0.4}),
                     beside = box_mesh({2, 0, 0}, {3, 1, 1});
  const ClosedMesh apart = make_closed(joined(outer, inside_out(beside)), "apart");
  CHECK(apart.components == 2);
  CHECK(apart.repair.turned_components == 1);
  CHECK(volume_m3(apart) == Approx(2.0));

  CHECK(volume_m3(make_closed(joined(outer, inside_out(inner)), "hollow")) == Approx(0.992));
  const ClosedMesh turned = make_closed(joined(inside_out(outer), inner), "hollow, inside out");
  CHECK(turned.repair.turned_components == 2);
  CHECK(volume_m3(turned) == Approx(0.992));
  CHECK_THROWS_WITH(make_closed(joined(outer, inner), "nested"),
                    Contains("nested: 1 of 2 pieces lie within another and face the same way"));
}

TEST_CASE("Pieces that touch in one point are set apart there", "[mesh_repair]") {
  TriangleMesh mesh = joined(cube_mesh(), box_mesh({1, 1, 1}, {2, 2, 2}));
  const ClosedMesh closed = make_closed(mesh, "touching");
  CHECK(closed.repair.split_vertices == 1);
  CHECK(closed.components == 2);
  CHECK(closed.mesh.vertices_m.size() == 16);
  CHECK(volume_m3(closed) == Approx(2.0));
}

TEST_CASE("Small holes are closed: a missing triangle, or a hundredth of the surface",
          "[mesh_repair]") {
  TriangleMesh cube = cube_mesh();
  cube.triangles.pop_back();
  const ClosedMesh closed = make_closed(cube, "cube");
  CHECK(closed.repair.holes.count == 1);
  CHECK(closed.repair.holes.longest_border_m == Approx(2.0 + std::sqrt(2.0)));
  CHECK(volume_m3(closed) == Approx(1.0));

  // Two round holes of a ball, at its poles.
  const auto without_caps = [](int rows) {
    TriangleMesh ball = ball_mesh(1.0, 32, 24);
    ball.triangles.resize(ball.triangles.size() - 64);
    ball.triangles.resize(ball.triangles.size() - static_cast<std::size_t>(64 * rows));
    ball.triangles.erase(ball.triangles.begin(), ball.triangles.begin() + 64 * rows);
    return ball;
  };
  const ClosedMesh ball = make_closed(without_caps(1), "ball");
  CHECK(ball.repair.holes.count == 2);
  CHECK(ball.components == 1);
  CHECK(volume_m3(ball) ==
        Approx(volume_m3(make_closed(ball_mesh(1.0, 32, 24), "whole"))).epsilon(1e-3));
  CHECK_THROWS_AS(make_closed(without_caps(6), "ball"), NotSolid);

  TriangleMesh alone = cube_mesh();
  alone.triangles.resize(1);
  CHECK_THROWS_AS(make_closed(alone, "alone"), NotSolid);
}

TEST_CASE("What cannot be repaired is refused with reason and counts", "[mesh_repair]") {
  TriangleMesh open = cube_mesh();
  open.triangles.resize(10);
  CHECK_THROWS_WITH(make_closed(open, "a.obj"),
                    Contains("a.obj: not closed: 4 boundary edges (of one face), 0 non-manifold"));

  TriangleMesh fin = cube_mesh();
  fin.vertices_m.push_back({2, 2, 2});
  fin.triangles.push_back({0, 1, 8});
  CHECK_THROWS_WITH(make_closed(fin, "a.obj"),
                    Contains("2 boundary edges") && Contains("1 non-man"));

  CHECK_THROWS_WITH(make_closed({}, "a.obj"), Contains("a.obj: 0 triangles"));
  CHECK_THROWS_WITH(make_closed({{{0, 0, 0}}, {{0, 0, 0}}}, "a.obj"),
                    Contains("every face is deg"));
  CHECK_THROWS_WITH(make_closed({{{0, 0, 0}, {1, 0, 0}}, {{0, 1, 2}}}, "a.obj"),
                    Contains("1 of 1 triangles name a vertex that is none: expected 0 to 1"));

  TriangleMesh lost = cube_mesh();
  lost.vertices_m[3].y() = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(make_closed(lost, "a.obj"), Contains("1 of 8 vertices are no numbers"));

  TriangleMesh flat = cube_mesh();
  for (Eigen::Vector3d& vertex : flat.vertices_m) vertex.z() *= 1e-14;
  CHECK_THROWS_AS(make_closed(flat, "a.obj"), MeshError);

  CHECK_THROWS_WITH(
      make_closed(joined(cube_mesh(), box_mesh({0.5, 0.3, 0.2}, {1.5, 0.7, 0.6})), "a.obj"),
      Contains("a.obj: its 2 pieces cut one another"));
}

TEST_CASE("A surface with one side is refused", "[mesh_repair]") {
  // Klein's bottle: a torus glued with its tube mirrored.
  constexpr int kAround = 12, kAcross = 8;
  TriangleMesh mesh;
  for (int i = 0; i < kAround * kAcross; ++i)
    mesh.vertices_m.push_back({std::cos(i), std::sin(2.0 * i), 0.1 * i});
  const auto at = [](int i, int j) {
    const int wrapped = i == kAround ? kAcross - j : j;
    return (i % kAround) * kAcross + wrapped % kAcross;
  };
  for (int i = 0; i < kAround; ++i)
    for (int j = 0; j < kAcross; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  CHECK_THROWS_WITH(make_closed(mesh, "klein"), Contains("klein: not orientable"));
}

}  // namespace
}  // namespace stillgrid::mesh::mesh_repair_test
