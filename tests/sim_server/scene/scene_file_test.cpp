#include "sim_server/scene/scene_file.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <ctime>
#include <string>
#include <vector>

#include "tests/sim_server/scene/full_scene.hpp"
#include "tests/sim_server/scene/temporary_scene.hpp"

namespace stillgrid::scene::scene_file_test {

namespace {

/// The nodes that a line about pins leaves pinned on a sheet of 4 x 3 nodes.
std::vector<int> pinned_sheet_nodes(const std::string& line) {
  return bodies::springs_of(scene_of(R"(format = 2
material = [{ name = "m", contact_stiffness_N_per_m = 1.0 }]
[[body]]
name = "sheet"
kind = "sheet"
nodes = [4, 3]
size_m = [0.3, 0.2]
mass_kg = 0.1
spring_stiffness_N_per_m = { structural = 1.0 }
material = "m"
)" + line)
                                .bodies.at(0))
      ->pinned_nodes;
}

/// The same on a thread of 6 nodes.
std::vector<int> pinned_thread_nodes(const std::string& line) {
  return bodies::springs_of(scene_of(R"(format = 2
material = [{ name = "m", contact_stiffness_N_per_m = 1.0 }]
[[body]]
name = "thread"
kind = "thread"
nodes = 6
from_m = [0, 0, 0]
to_m = [1, 0, 0]
mass_kg = 0.1
spring_stiffness_N_per_m = { structural = 1.0 }
material = "m"
)" + line)
                                .bodies.at(0))
      ->pinned_nodes;
}

}  // namespace

TEST_CASE("A scene of its format alone has every default", "[scene_file]") {
  const SceneDescription scene = scene_of("format = 2\n");

  CHECK(scene.gravity_m_s2 == Eigen::Vector3d(0.0, 0.0, -9.81));
  CHECK(scene.period_s == 0.01);
  CHECK(scene.method == Method{});
  CHECK_FALSE(scene.choose_method);
  CHECK(scene.voxel_ratio == 0.0);
  CHECK(scene.materials.empty());
  CHECK(scene.bodies.empty());
  REQUIRE(scene.tool.size() == 1);
  CHECK(scene.tool[0].radius_m == 0.005);
  CHECK(scene.tool[0].position_m.isZero(0.0));
  CHECK(scene.device.scale == 1.0);
}

TEST_CASE("Bodies may sleep unless the scene says no", "[scene_file]") {
  CHECK(scene_of("format = 2\n").sleeping);
  CHECK_FALSE(scene_of("format = 2\nsimulation.sleeping = false\n").sleeping);
}

TEST_CASE("A rate is the inverse of a period", "[scene_file]") {
  CHECK(scene_of("format = 2\nsimulation.rate_hz = 33\n").period_s == Approx(1.0 / 33.0));
  CHECK(scene_of("format = 2\nsimulation.period_s = 0.033\n").period_s == 0.033);
}

TEST_CASE("A hand is read with the time to rest before it", "[scene_file]") {
  const SceneDescription scene =
      scene_of("format = 2\n[hand]\nfile = 'sub/press.csv'\nsettle_s = 1.5\n");
  REQUIRE(scene.hand);
  CHECK(scene.hand->file.filename() == "press.csv");
  CHECK(scene.hand->file.parent_path().filename() == "sub");
  CHECK(scene.hand->settle_s == 1.5);
  CHECK_FALSE(scene_of("format = 2\n").hand);
}

TEST_CASE("A scene is named after its file", "[scene_file]") {
  const TemporaryScene file("format = 2");
  CHECK(load_scene(file.path()).name == file.path().stem());
}

TEST_CASE("What a scene says of the world, the tool and the device is read", "[scene_file]") {
  const SceneDescription scene = scene_of(kFullScene);

  CHECK(scene.gravity_m_s2 == Eigen::Vector3d(0.0, -1.5, 0.0));
  CHECK(scene.period_s == 0.02);
  CHECK(scene.voxel_ratio == 1.25);
  REQUIRE(scene.tool.size() == 2);
  CHECK(scene.tool[0].radius_m == 0.004);
  CHECK(scene.tool[1].position_m == Eigen::Vector3d(0.0, 0.0, 0.01));
  CHECK(scene.device.position_m == Eigen::Vector3d(0.1, 0.2, 0.3));
  CHECK(scene.device.scale == 2.0);
  REQUIRE(scene.materials.size() == 2);
  CHECK(scene.materials[0].slip_speed_m_s == 1e-3);
  CHECK(scene.materials[1].contact_stiffness_N_per_m == 900.0);
  CHECK(scene.materials[1].slip_speed_m_s == 0.005);
}

TEST_CASE("A quaternion that is nearly unit is made unit", "[scene_file]") {
  const Eigen::Quaterniond orientation = scene_of(kFullScene).device.orientation;
  CHECK(orientation.norm() == Approx(1.0).epsilon(1e-15));
  CHECK(orientation.z() == Approx(std::sqrt(0.5)));
  CHECK(orientation.w() == Approx(std::sqrt(0.5)));
}

TEST_CASE("Deforming bodies are read with their springs, spheres and pins", "[scene_file]") {
  const SceneDescription scene = scene_of(kFullScene);
  REQUIRE(scene.bodies.size() == 8);

  const auto& cloth = std::get<bodies::SheetBody>(scene.bodies[0].shape);
  CHECK(scene.bodies[0].motion == bodies::Motion::kFree);
  CHECK(cloth.nodes == Eigen::Vector2i(3, 4));
  CHECK(cloth.size_m == Eigen::Vector2d(0.2, 0.3));
  CHECK(cloth.springs.structural_stiffness_N_per_m == 50.0);
  CHECK(cloth.springs.shear_stiffness_N_per_m == 20.0);
  CHECK(cloth.springs.bend_stiffness_N_per_m == 5.0);
  CHECK(cloth.springs.spring_damping_N_s_per_m == 0.1);
  CHECK(cloth.springs.spring_rest_ratio == 0.9);
  CHECK(cloth.spheres.spacing_m == 0.02);
  CHECK(cloth.spheres.radius_m == 0.015);
  CHECK(scene.bodies[0].velocity_m_s == Eigen::Vector3d(0.0, 0.0, 1.0));

  const auto& thread = std::get<bodies::ThreadBody>(scene.bodies[1].shape);
  CHECK(thread.nodes == 5);
  CHECK(scene.bodies[1].position_m.isApprox(Eigen::Vector3d(0.0, 0.0, 0.3)));
  CHECK(thread.springs.pinned_nodes == std::vector<int>{0, 4});
  CHECK(scene.bodies[1].material == 0);

  const auto& sponge = std::get<bodies::SoftBlockBody>(scene.bodies[2].shape);
  CHECK(sponge.lattice.cells == Eigen::Vector3i(2, 1, 3));
  CHECK(sponge.lattice.nodes_m.size() == 24);
  CHECK(sponge.springs.shear_stiffness_N_per_m == 40.0);
  CHECK(sponge.spheres.radius_m == 0.02);
  CHECK(sponge.springs.pinned_nodes == std::vector<int>{0, 1, 2, 3, 4, 5});  // the lowest layer
}

TEST_CASE("Rigid bodies are read with their motion, directions made unit", "[scene_file]") {
  const SceneDescription scene = scene_of(kFullScene);
  REQUIRE(scene.bodies.size() == 8);

  const bodies::BodyDescription& box = scene.bodies[3];
  REQUIRE(std::holds_alternative<bodies::CompoundBody>(box.shape));
  CHECK(std::get<bodies::CompoundBody>(box.shape).shapes.at(0).half_m ==
        Eigen::Vector3d(0.05, 0.1, 0.15));
  CHECK(box.mass_kg == 0.5);
  CHECK(box.angular_velocity_rad_s == Eigen::Vector3d::UnitX());
  CHECK(box.material == 1);

  const bodies::BodyDescription& shaker = scene.bodies[4];
  CHECK(shaker.motion == bodies::Motion::kPrescribed);
  CHECK(shaker.prescribed.direction == Eigen::Vector3d::UnitZ());
  CHECK(shaker.prescribed.amplitude_m == 0.01);
  CHECK(shaker.prescribed.frequency_hz == 2.0);
  CHECK(shaker.prescribed.velocity_m_s == Eigen::Vector3d::Zero());

  const bodies::BodyDescription& runner = scene.bodies[5];
  CHECK(runner.prescribed.velocity_m_s == Eigen::Vector3d(-0.1, 0.0, 0.2));
  CHECK(runner.velocity_m_s.isZero(0.0));
  CHECK(runner.prescribed.keyframes == nullptr);

  const bodies::BodyDescription& floor = scene.bodies[6];
  CHECK(floor.motion == bodies::Motion::kStatic);
  CHECK(floor.position_m == Eigen::Vector3d(0.0, 0.0, -1.0));
  CHECK(std::get<bodies::PlaneBody>(floor.shape).normal.isApprox(Eigen::Vector3d(0.0, 0.6, 0.8)));
}

TEST_CASE("A body of any kind but a plane may be stiffer than its material", "[scene_file]") {
  const std::string before =
      "format = 2\nmaterial = [{ name = 'm', contact_stiffness_N_per_m = 1 }]\n[[body]]\nname = "
      "'b'\n"
      "material = 'm'\nmotion = 'static'\n";
  for (const std::string kind :
       {"kind = 'sheet'\nnodes = [2, 2]\nsize_m = [1, 1]\n",
        "kind = 'thread'\nnodes = 2\nfrom_m = [0, 0, 0]\nto_m = [1, 0, 0]\n",
        "kind = 'soft_block'\nnodes = [2, 2, 2]\nsize_m = [1, 1, 1]\n",
        "kind = 'rigid_box'\nsize_m = [1, 1, 1]\n", "kind = 'sphere'\nradius_m = 1\n"}) {
    INFO(kind);
    CHECK(scene_of(before + kind).bodies.at(0).stiffness_scale == 1.0);
    CHECK(scene_of(before + kind + "stiffness_scale = 1.96").bodies.at(0).stiffness_scale == 1.96);
  }
}

TEST_CASE("A word pins the nodes it names", "[scene_file]") {
  using Nodes = std::vector<int>;
  CHECK(pinned_sheet_nodes("pinned = 'none'").empty());
  CHECK(pinned_sheet_nodes("pinned = 'corners'") == Nodes{0, 3, 8, 11});
  CHECK(pinned_sheet_nodes("pinned = 'two_corners'") == Nodes{8, 11});
  CHECK(pinned_sheet_nodes("pinned = 'edges'") == Nodes{0, 1, 2, 3, 4, 7, 8, 9, 10, 11});
  CHECK(pinned_sheet_nodes("pinned = 'top'") == Nodes{8, 9, 10, 11});
  CHECK(pinned_sheet_nodes("pinned = [11, 2, 11]") == Nodes{2, 11});
  CHECK(pinned_sheet_nodes("pinned = []").empty());

  CHECK(pinned_sheet_nodes("").empty());

  CHECK(pinned_thread_nodes("pinned = 'none'").empty());
  CHECK(pinned_thread_nodes("pinned = 'start'") == Nodes{0});
  CHECK(pinned_thread_nodes("pinned = 'end'") == Nodes{5});
  CHECK(pinned_thread_nodes("pinned = 'both'") == Nodes{0, 5});
}

TEST_CASE("A scene has at most 64 planes, for a segment has room for no more", "[scene_file]") {
  std::string text = "format = 2\nmaterial = [{ name = \"m\", contact_stiffness_N_per_m = 1.0 }]\n";
  for (int i = 0; i < 64; ++i)
    text.append("[[body]]\nkind = \"plane\"\nnormal = [0, 0, 1]\nmaterial = \"m\"\nname = \"p")
        .append(std::to_string(i))
        .append("\"\n");
  CHECK(scene_of(text).bodies.size() == 64);
  text.append(
      "[[body]]\nkind = \"plane\"\nnormal = [0, 0, 1]\nmaterial = \"m\"\nname = \"one more\"\n");
  CHECK(refusal_of(text).find("at most 64 planes") != std::string::npos);
}

namespace {

/// A scene of so many spheres, a line of them.
std::string many_spheres(int count) {
  std::string text = "format = 2\n[[material]]\nname = 'm'\ncontact_stiffness_N_per_m = 1\n";
  for (int i = 0; i < count; ++i)
    text += "[[body]]\nname = 'ball" + std::to_string(i) +
            "'\nkind = 'sphere'\nradius_m = 0.01\nmass_kg = 1\nmaterial = 'm'\nposition_m = [0.0, "
            "0.0, " +
            std::to_string(i) + ".0]\n";
  return text;
}

/// Processor time that a text takes to be read, s: the least of three, which is the work.
double reading_s(const std::string& text) {
  double least_s = 1e9;
  for (int i = 0; i < 3; ++i) {
    const std::clock_t began = std::clock();
    REQUIRE_FALSE(scene_of(text).bodies.empty());
    least_s = std::min(least_s, static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC);
  }
  return least_s;
}

}  // namespace

TEST_CASE("The time that a scene takes to be read grows with its bodies, no faster",
          "[scene_file]") {
  // Looking through all names for each took 25 times as long here.
  CHECK(reading_s(many_spheres(24'000)) < 14.0 * reading_s(many_spheres(3'000)));
}

}  // namespace stillgrid::scene::scene_file_test
