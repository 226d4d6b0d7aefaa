#include "sim_server/mesh/mesh_file.hpp"

#include <catch2/catch.hpp>
#include <iomanip>

#include "sim_server/mesh/mass_properties.hpp"
#include "sim_server/mesh/mesh_repair.hpp"
#include "tests/sim_server/mesh/solids.hpp"
#include "tests/test_folder.hpp"

namespace stillgrid::mesh::mesh_file_test {
namespace {

using Catch::Contains;

std::string as_obj(const TriangleMesh& mesh) {
  std::ostringstream text;
  for (const auto& v : mesh.vertices_m)
    text << "v " << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
  for (const auto& t : mesh.triangles)
    text << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  return text.str();
}

std::string as_off_or_ply(const TriangleMesh& mesh, bool ply) {
  std::ostringstream text;
  if (ply)
    text << "ply\nformat ascii 1.0\nelement vertex " << mesh.vertices_m.size()
         << "\nproperty float x\nproperty float y\nproperty float z\nelement face "
         << mesh.triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
  else
    text << "OFF\n" << mesh.vertices_m.size() << ' ' << mesh.triangles.size() << " 0\n";
  for (const auto& v : mesh.vertices_m) text << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
  for (const auto& t : mesh.triangles) text << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  return text.str();
}

std::string as_stl(const TriangleMesh& mesh) {
  std::ostringstream text;
  text << "solid box\n";
  for (const auto& t : mesh.triangles) {
    text << "facet normal 0 0 0\nouter loop\n";
    for (const int i : t) {
      const auto& v = mesh.vertices_m[static_cast<std::size_t>(i)];
      text << "vertex " << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
    }
    text << "endloop\nendfacet\n";
  }
  text << "endsolid box\n";
  return text.str();
}

TEST_CASE("OBJ, OFF, PLY and STL files hold the same solid, in metres after scaling",
          "[mesh_file]") {
  const tests::TestFolder folder;
  const TriangleMesh box = box_mesh({1, 2, 3}, {2, 4, 6});
  for (const auto& file :
       {folder.write("a.obj", as_obj(box)), folder.write("a.off", as_off_or_ply(box, false)),
        folder.write("a.ply", as_off_or_ply(box, true)), folder.write("a.stl", as_stl(box))}) {
    const ClosedMesh closed = make_closed(load_mesh(file, 0.1), file.string());
    CHECK(closed.mesh.vertices_m.size() == 8);
    const MassProperties properties = mass_properties(closed.mesh);
    CHECK(properties.volume_m3 == Approx(6e-3).epsilon(1e-6));
    CHECK((properties.centre_m - Eigen::Vector3d(0.15, 0.3, 0.45)).norm() < 1e-6);
  }
}

TEST_CASE("Polygons are cut into triangles, and normals keep no corner apart", "[mesh_file]") {
  const tests::TestFolder folder;
  const auto file =
      folder.write("quads.obj",
                   "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n"
                   "vn 0 0 -1\nvn 0 0 1\nvn 0 -1 0\nvn 0 1 0\nvn -1 0 0\nvn 1 0 0\n"
                   "f 1//1 3//1 4//1 2//1\nf 5//2 6//2 8//2 7//2\nf 1//3 2//3 6//3 5//3\n"
                   "f 3//4 7//4 8//4 4//4\nf 1//5 5//5 7//5 3//5\nf 2//6 4//6 8//6 6//6\n");
  const TriangleMesh mesh = load_mesh(file, 1.0);
  CHECK(mesh.triangles.size() == 12);
  CHECK(mesh.vertices_m.size() == 8);
}

TEST_CASE("A file that is no mesh is refused in one line that names it", "[mesh_file]") {
  const tests::TestFolder folder;
  const auto refusal = [](const std::filesystem::path& file, double scale = 1.0) {
    try {
      (void)load_mesh(file, scale);
    } catch (const MeshError& error) {
      const std::string text = error.what();
      CHECK(text.find('\n') == std::string::npos);
      CHECK(text.find(file.string()) == 0);
      return text;
    }
    return std::string("none");
  };
  CHECK_THAT(refusal(folder.path / "absent.obj"), Contains("no such file"));
  CHECK_THAT(refusal(folder.path), Contains("is a folder"));
  CHECK_THAT(refusal(folder.write("empty.stl", "")), Contains("value 0 bytes"));
  CHECK_THAT(refusal(folder.write("text.txt", "hello")), Contains("expected .obj"));
  CHECK_THAT(refusal(folder.write("cut.off", "OFF\n8 12 0\n0 0 0\n")), !Contains("none"));
  CHECK_THAT(refusal(folder.write("points.obj", "v 0 0 0\nv 1 0 0\n")), !Contains("none"));
  CHECK_THAT(refusal(folder.write("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n")),
             Contains("expected finite coordinates"));
  const auto cube = folder.write("cube.obj", as_obj(cube_mesh()));
  CHECK_THAT(refusal(cube, 1e4), Contains("value 10000 m") && Contains("1e-6 to 1000 m"));
  CHECK_THAT(refusal(cube, 1e-8), Contains("value 1e-08 m"));
  const auto far = folder.write("far.obj", as_obj(box_mesh({5e3, 0, 0}, {5.001e3, 1, 1})));
  CHECK_THAT(refusal(far), Contains("farthest coordinate: value 5001 m"));
}

std::filesystem::path meshes_of_others() {
  const char* data = std::getenv("STILLGRID_DATA");
  return (data ? std::filesystem::path(data)
               : std::filesystem::path(STILLGRID_SOURCE_DIR) / ".." / "shared" / "data") /
         "meshes";
}

TEST_CASE("Meshes made by others are read and repaired, or refused with counts",
          "[mesh_file][real_data]") {
  const auto folder = meshes_of_others();
  if (!std::filesystem::exists(folder)) {
    WARN("skipped: no meshes in " << folder);
    return;
  }
  const auto closed = [&](const char* file) {
    return make_closed(load_mesh(folder / file, 1.0), file);
  };
  for (const auto& [file, triangles] : {std::pair("ku_contour.stl", 1770U),
                                        {"npm_bunny.off", 3674U},
                                        {"mujoco_spot.obj", 5856U},
                                        {"sofa_torus.obj", 1600U}}) {
    const ClosedMesh mesh = closed(file);
    CHECK(mesh.mesh.triangles.size() == triangles);
    CHECK(mesh.components == 1);
    CHECK(mesh.folds == 0);
    CHECK(mass_properties(mesh.mesh).volume_m3 > 0.0);
  }
  CHECK(closed("sofa_liver-smooth.obj").folds == 6);
  CHECK(closed("sofa_torus2_scale3_for_collision.obj").repair.doubled_faces == 400);
  CHECK_THROWS_WITH(closed("npm_teapot.off"), Contains("64 boundary edges"));
}

}  // namespace
}  // namespace stillgrid::mesh::mesh_file_test
