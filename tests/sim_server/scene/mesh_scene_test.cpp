#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "sim_server/scene/scene_file.hpp"
#include "tests/sim_server/scene/temporary_scene.hpp"

namespace stillgrid::scene::mesh_scene_test {

namespace {

/// A file that exists as long as this object does.
class TemporaryFile {
 public:
  TemporaryFile(const std::string& text, const std::string& extension) {
    static int count = 0;
    path_ = std::filesystem::temp_directory_path() / ("stillgrid_mesh_" + std::to_string(getpid()) +
                                                      "_" + std::to_string(count++) + extension);
    std::ofstream(path_) << text;
  }
  ~TemporaryFile() { std::filesystem::remove(path_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  [[nodiscard]] std::string name() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

/// A brick of 4 x 2 x 1 whose lowest corner is the origin; without a side if open.
std::string brick(bool open = false) {
  std::string text;
  for (int i = 0; i < 8; ++i)
    text += "v " + std::to_string(4 * (i & 1)) + ' ' + std::to_string(i & 2) + ' ' +
            std::to_string(i >> 2) + '\n';
  text +=
      "f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 7 3\n";
  return open ? text : text + "f 2 4 8\nf 2 8 6\n";
}

/// Three balls in a row along the brick's middle, at a scale of a hundredth.
constexpr const char* kSpheres =
    "x_m,y_m,z_m,radius_m\n0.005,0.01,0.005,0.005\n0.02,0.01,0.005,0.01\n0.035,0.01,0.005,0.005\n";

const std::string kBefore =
    "format = 2\nmaterial = [{ name = 'm', contact_stiffness_N_per_m = 100.0 }]\n[[body]]\n"
    "name = 'b'\nkind = 'mesh'\nmaterial = 'm'\nmass_kg = 2.0\nscale = 0.01\n";
// What stands on line 9.
std::string file_line(const std::string& name) {
  return "file = '" + name + "'\n";
}
std::string spheres_line(const TemporaryFile& file) {
  return "spheres = { file = '" + file.name() + "' }\n";
}
const std::string kSprings = "spring_stiffness_N_per_m = { structural = 10.0, shear = 5.0 }\n";

}  // namespace

TEST_CASE("A rigid mesh stands in its centre of mass along its principal axes", "[mesh_scene]") {
  const TemporaryFile mesh(brick(), ".obj"), spheres(kSpheres, ".csv");
  const bodies::BodyDescription body =
      scene_of(kBefore + file_line(mesh.name()) + spheres_line(spheres) +
               "position_m = [1, 2, 3]\norientation_xyzw = [0, 0, 0.7071, 0.7071]\n")
          .bodies.at(0);

  // A quarter turn about z, of the brick's middle.
  CHECK(body.position_m.isApprox(Eigen::Vector3d(1 - 0.01, 2 + 0.02, 3.005)));
  // (b^2 + c^2) / 12 of 40, 20 and 10 mm, ascending.
  const auto& rigid = std::get<bodies::RigidMeshBody>(body.shape);
  CHECK(rigid.inertia_per_kg_m2.isApprox(Eigen::Vector3d(5e-4, 17e-4, 20e-4) / 12.0));
  REQUIRE(rigid.balls.size() == 3);
  const Eigen::Vector3d end_m = body.position_m + body.orientation * rigid.balls[2].centre_m;
  CHECK(end_m.isApprox(Eigen::Vector3d(1 - 0.01, 2 + 0.035, 3.005)));
  CHECK(rigid.balls[1].radius_m == 0.01);
  CHECK(body.stiffness_scale == 1.0);
}

TEST_CASE("A soft mesh has a method that bears many neighbours, unless one is named",
          "[mesh_scene]") {
  const TemporaryFile mesh(brick(), ".obj"), spheres(kSpheres, ".csv");
  const std::string rigid = kBefore + file_line(mesh.name()) + spheres_line(spheres);
  const std::string soft = rigid + kSprings + "lattice_m = 0.01\n";
  const auto method = [](const std::string& text) { return describe(scene_of(text).method); };

  CHECK(method(rigid) == "implicit_euler");
  CHECK(method(soft) == "velocity_verlet");
  std::string still = soft;
  still.replace(still.find("mass_kg = 2.0"), 13, "motion = 'static'");
  CHECK(method(still) == "implicit_euler");
  CHECK(method(soft + "[simulation]\nintegrator = 'implicit_euler'\n") == "implicit_euler");
  CHECK(method(soft + "[simulation]\nsubsteps = 2\n") == "implicit_euler, 2 substeps");
}

TEST_CASE("A mesh with springs is soft, in the frame of its file, pinned within a box",
          "[mesh_scene]") {
  const TemporaryFile mesh(brick(), ".obj"), spheres(kSpheres, ".csv");
  const std::string text = kBefore + file_line(mesh.name()) + spheres_line(spheres) + kSprings +
                           "lattice_m = 0.01\nposition_m = [1, 0, 0]\n";
  const bodies::BodyDescription body =
      scene_of(text + "pinned = { low_m = [0.9, -1, -1], high_m = [1.011, 1, 1] }\n").bodies.at(0);

  CHECK(body.position_m == Eigen::Vector3d(1, 0, 0));
  const auto& soft = std::get<bodies::SoftMeshBody>(body.shape);
  CHECK(soft.balls[0].centre_m == Eigen::Vector3d(0.005, 0.01, 0.005));
  CHECK(soft.springs.structural_stiffness_N_per_m == 10.0);
  CHECK(soft.springs.shear_stiffness_N_per_m == 5.0);
  REQUIRE_FALSE(soft.springs.pinned_nodes.empty());
  CHECK(soft.springs.pinned_nodes.size() < soft.lattice.nodes_m.size());
  std::size_t within = 0;
  for (const Eigen::Vector3d& node_m : soft.lattice.nodes_m) within += node_m.x() <= 0.011;
  CHECK(soft.springs.pinned_nodes.size() == within);
  const auto pinned = [&](const std::string& line) {
    return bodies::springs_of(scene_of(text + line).bodies.at(0))->pinned_nodes;
  };
  CHECK(pinned("pinned = 'none'\n").empty());
  CHECK(pinned("pinned = [2, 0, 2]\n") == std::vector<int>{0, 2});
}

TEST_CASE("A soft mesh without spheres has even ones, and a note of the force that crushes it",
          "[mesh_scene]") {
  const TemporaryFile mesh(brick(), ".obj");
  const std::string text = kBefore + file_line(mesh.name()) + kSprings + "lattice_m = 0.005\n";
  const SceneDescription scene = scene_of(text),
                         by_key = scene_of(text + "spheres = { surface_spacing_m = 0.0025 }\n");
  const auto balls = bodies::balls_of(scene.bodies.at(0));
  const auto same = bodies::balls_of(by_key.bodies.at(0));

  CHECK(balls.size() == same.size());
  CHECK(balls.size() > 200);  // on 28 cm^2
  for (const spheres::Ball& ball : balls) CHECK(ball.radius_m <= 0.0025);
  REQUIRE(scene.notes.size() == 2);
  CHECK(scene.notes[1] == "body 'b': a tool may crush it by more than 0.1 N");
}

TEST_CASE("A scene decomposes a mesh to its tolerance and says so in a note", "[mesh_scene]") {
  const TemporaryFile mesh(brick(), ".obj");
  const SceneDescription scene =
      scene_of(kBefore + file_line(mesh.name()) + "spheres = { tolerance_m = 0.003 }\n");

  const std::size_t count = bodies::balls_of(scene.bodies.at(0)).size();
  CHECK(count > 1);
  REQUIRE(scene.notes.size() == 1);
  CHECK(scene.notes[0].starts_with("body 'b': " + std::to_string(count) + " spheres within 0.00"));
}

TEST_CASE("A scene samples a mesh evenly, below its surface or through its volume",
          "[mesh_scene]") {
  const TemporaryFile mesh(brick(), ".obj");
  const auto scene = [&](const std::string& key) {
    return scene_of(kBefore + file_line(mesh.name()) + "spheres = { " + key + " = 0.005 }\n");
  };
  // 40 x 20 x 10 mm hold 8 x 4 x 2 cells, their corners' cells farthest out.
  const SceneDescription volume = scene("volume_spacing_m");
  REQUIRE(bodies::balls_of(volume.bodies.at(0)).size() == 64);
  CHECK(bodies::balls_of(volume.bodies[0])[0].radius_m == Approx(0.005 * (1 + std::sqrt(3.0)) / 4));
  REQUIRE(volume.notes.size() == 1);
  CHECK(volume.notes[0].starts_with("body 'b': 64 even spheres, in "));

  const SceneDescription surface = scene("surface_spacing_m");
  CHECK(bodies::balls_of(surface.bodies.at(0)).size() > 50);  // on 28 cm^2
  // Each as large as fits into 10 mm.
  for (const spheres::Ball& ball : bodies::balls_of(surface.bodies[0]))
    CHECK(ball.radius_m <= 0.005 + 1e-12);
}

TEST_CASE("A mesh relative to the scene's folder is found", "[mesh_scene]") {
  const TemporaryFile mesh(brick(), ".obj"), spheres(kSpheres, ".csv");
  const std::string name = std::filesystem::path(mesh.name()).filename().string();
  CHECK(refusal_of(kBefore + file_line(name) + spheres_line(spheres)).empty());
}

TEST_CASE("Materials and bodies of a stiffness of their own together are at most 64",
          "[mesh_scene]") {
  const TemporaryFile mesh(brick(), ".obj"), spheres(kSpheres, ".csv");
  std::string materials = "format = 2\n";
  for (int i = 0; i < 64; ++i)
    materials +=
        "[[material]]\nname = '" + std::to_string(i) + "'\ncontact_stiffness_N_per_m = 1\n";
  const std::string body =
      "[[body]]\nname = 'b'\nkind = 'mesh'\nmaterial = '0'\nmass_kg = 1\nscale = 0.01\n" +
      file_line(mesh.name()) + spheres_line(spheres);

  CHECK(refusal_of(materials + body).empty());
  CHECK(refusal_of(materials + body + "stiffness_scale = 2.0\n")
            .find("body.stiffness_scale: value 2: expected at most 64 materials and bodies of") !=
        std::string::npos);
}

TEST_CASE("A small hole of a mesh is closed, with a line that says so", "[mesh_scene]") {
  std::string text = brick();
  text.resize(text.size() - 8);  // the last face
  const TemporaryFile mesh(text, ".obj");
  const SceneDescription scene = scene_of(kBefore + file_line(mesh.name()));
  CHECK(bodies::field_of(scene.bodies.at(0)) != nullptr);
  REQUIRE(scene.notes.size() == 2);
  CHECK(scene.notes[0] == "body 'b': small holes closed: 1, the longest border 0.0524 m");
}

TEST_CASE("A rigid mesh that bounds no solid is a shell, with the inertia of its area",
          "[mesh_scene]") {
  const TemporaryFile sheet("v 0 0 0\nv 4 0 0\nv 4 2 0\nv 0 2 0\nf 1 2 3 4\n", ".obj");
  const SceneDescription scene = scene_of(kBefore + file_line(sheet.name()));
  const auto& rigid = std::get<bodies::RigidMeshBody>(scene.bodies.at(0).shape);
  // b^2 / 12 and a^2 / 12 of 40 and 20 mm, and their sum.
  CHECK(rigid.inertia_per_kg_m2.isApprox(Eigen::Vector3d(4e-4, 16e-4, 20e-4) / 12.0));
  CHECK(rigid.field == nullptr);
  REQUIRE(scene.notes.size() == 1);
  CHECK(scene.notes[0].find("not closed: 4 boundary edges") != std::string::npos);
  CHECK(scene.notes[0].find(": a thin shell of " + std::to_string(rigid.balls.size()) +
                            " spheres of 0.000625 m") != std::string::npos);
  for (const char* const key :
       {"field = {}\n", "contact = 'field'\n", "spheres = { tolerance_m = 0.001 }\n"})
    CHECK(
        refusal_of(kBefore + file_line(sheet.name()) + key).starts_with("9:8: body.file: value '"));
}

TEST_CASE("A mesh that bounds no solid is refused in one line at its file", "[mesh_scene]") {
  const TemporaryFile open(brick(true), ".obj"), empty("", ".obj"),
      nonsense("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", ".obj"), spheres(kSpheres, ".csv");
  for (const std::string& name :
       {open.name(), empty.name(), nonsense.name(), std::string("/nowhere/at all.obj")}) {
    const std::string line = refusal_of(kBefore + file_line(name) + spheres_line(spheres));
    INFO(line);
    CHECK(line.starts_with("9:8: body.file: value '"));
    CHECK(line.find("': expected a mesh that bounds a solid; ") != std::string::npos);
    CHECK(line.find('\n') == std::string::npos);
  }
}

TEST_CASE("A fault in the keys of a mesh is refused where it stands", "[mesh_scene]") {
  const TemporaryFile mesh(brick(), ".obj"), spheres(kSpheres, ".csv"),
      nonsense("x,y,z,radius\n", ".csv"),
      strays("x_m,y_m,z_m,radius_m\n0.5,1,0.5,0.5\n0.01,0.01,0.005,0.005\n", ".csv");
  const std::string before = kBefore + file_line(mesh.name());
  const std::string whole = before + spheres_line(spheres);
  struct Fault {
    std::string text, refusal;
  };
  const Fault faults[] = {
      {kBefore, "3:1: body.file: value missing: expected the path of a file"},
      {kBefore + "file = 3\n", "9:8: body.file: value 3: expected the path of a file, found"},
      {kBefore + "file = ''\n", "9:8: body.file: value '': expected the path of a file"},
      {before + "spheres = { tolerance_m = 1e-6 }\n",
       "10:27: body.spheres.tolerance_m: value 1e-06: expected at least a thousandth"},
      {before + "spheres = { tolerance_m = 0.01, file = 'x.csv' }\n",
       "10:27: body.spheres.tolerance_m: value 0.01: expected one of tolerance_m, surface_"},
      {before + "spheres = { tolerance_m = 0.005, spacing_m = 0.01 }\n",
       "10:34: body.spheres.spacing_m: value 0.01: unknown key `spacing_m`: did you mean `"},
      {before + "spheres = { surface_spacing_m = 0.01, volume_spacing_m = 0.01 }\n",
       "10:58: body.spheres.volume_spacing_m: value 0.01: expected one of tolerance_m, surface_"},
      {before + "spheres = { surface_spacing_m = -1 }\n",
       "10:33: body.spheres.surface_spacing_m: value -1: expected a number from 1e-9"},
      {before + "spheres = { volume_spacing_m = 1e-6 }\n",
       "10:32: body.spheres.volume_spacing_m: value 1e-06: expected a spacing that suits the mesh; "
       "sampling: about 8e+12 balls"},
      {before + "spheres = { file = '/nowhere.csv' }\n",
       "10:20: body.spheres.file: value '/nowhere.csv': expected a file of sphere_decompose; "},
      {before + spheres_line(nonsense), "10:20: body.spheres.file: value '"},
      {before + spheres_line(strays), "10:20: body.spheres.file: value '"},
      {whole + "lattice_m = 0.01\n",
       "11:1: body.lattice_m: value 0.01: expected no such key here, but "},
      {whole + "motion = 'prescribed'\nvelocity_m_s = [1, 0, 0]\n" + kSprings,
       "11:10: body.motion: value 'prescribed': expected one of free, static"},
      {whole + kSprings, "3:1: body.lattice_m: value missing: expected a number from 1e-9"},
      {before + kSprings + "lattice_m = 0.1\n",
       "11:13: body.lattice_m: value 0.1: expected at most twice the body's thickness, or "
       "`spheres`"},
      {whole + kSprings + "lattice_m = 1e-5\n",
       "12:13: body.lattice_m: value 1e-05: expected a lattice of at most 100000 nodes"},
      {whole + kSprings + "lattice_m = 0.01\npinned = 'top'\n",
       "13:10: body.pinned: value 'top': expected one of none"},
      {whole + kSprings + "lattice_m = 0.01\npinned = [-1]\n",
       "13:11: body.pinned: value -1: expected an integer from 0 to "},
      {whole + kSprings + "lattice_m = 0.01\npinned = { low_m = [5, 5, 5], high_m = [6, 6, 6] }\n",
       "13:10: body.pinned: value {...}: expected a box with a node of the body in it"},
      {whole + kSprings + "lattice_m = 0.01\npinned = { low_m = [5, 5, 5] }\n",
       "13:10: body.pinned.high_m: value missing: expected 3 numbers"},
  };
  for (const Fault& fault : faults) {
    const std::string line = refusal_of(fault.text);
    INFO(line);
    CHECK(line.substr(0, fault.refusal.size()) == fault.refusal);
    CHECK(line.find('\n') == std::string::npos);
  }
  CHECK(refusal_of(before + spheres_line(strays)).find("the centres of 1 of 2 lie outside") !=
        std::string::npos);
}

}  // namespace stillgrid::scene::mesh_scene_test
