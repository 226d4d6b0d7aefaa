#include <catch2/catch.hpp>
#include <string>

#include "tests/sim_server/scene/full_scene.hpp"
#include "tests/sim_server/scene/temporary_scene.hpp"

namespace stillgrid::scene::joint_scene_test {
namespace {

const std::string kBodies = R"(format = 2
[[material]]
name = "m"
contact_stiffness_N_per_m = 500.0
[[body]]
name = "box"
kind = "rigid_box"
size_m = [0.1, 0.1, 0.1]
mass_kg = 0.1
material = "m"
[[body]]
name = "thread"
kind = "thread"
nodes = 5
from_m = [0.05, 0.0, 0.0]
to_m = [0.09, 0.0, 0.0]
mass_kg = 0.01
spring_stiffness_N_per_m = { structural = 100.0 }
material = "m"
[[body]]
name = "post"
kind = "sphere"
motion = "static"
radius_m = 0.01
material = "m"
[[joint]]
)";

TEST_CASE("A joint is read with its bodies, points and springs", "[joint_scene]") {
  const SceneDescription scene = scene_of(kFullScene);
  REQUIRE(scene.joints.size() == 1);
  const JointDescription& joint = scene.joints[0];
  CHECK(joint.name == "hinge");
  CHECK(scene.bodies[static_cast<std::size_t>(joint.body_a)].name == "box");
  CHECK(scene.bodies[static_cast<std::size_t>(joint.body_b)].name == "runner");
  REQUIRE(joint.points_m.size() == 2);
  CHECK(joint.points_m[1] == Eigen::Vector3d(0.5, 0.1, 0.0));
  CHECK(joint.stiffness_N_per_m == 300.0);
  CHECK(joint.damping_N_s_per_m == 0.4);
  CHECK(joint.collide);

  const SceneDescription hung = scene_of(
      kBodies + "name = 'j'\nbody = 'thread'\npoints_m = [[0.09, 0, 0]]\nstiffness_N_per_m = 9\n");
  CHECK(hung.joints[0].body_b == -1);
  CHECK(hung.joints[0].damping_N_s_per_m == 0.0);
  CHECK_FALSE(hung.joints[0].collide);
}

TEST_CASE("A joint that cannot be is refused in a line that says what was expected",
          "[joint_scene]") {
  const std::string springs = "stiffness_N_per_m = 9\n";
  struct Case {
    std::string text, says;
  };
  const Case bad = GENERATE_COPY(
      Case{"name = 'j'\nbody = 'bxo'\npoints_m = [[0, 0, 0]]\n" + springs,
           "28:8: joint.body: value 'bxo': expected one of box, thread, post"},
      Case{"name = 'j'\nbody = 'box'\njoined_to = 'box'\npoints_m = [[0, 0, 0]]\n" + springs,
           "29:13: joint.joined_to: value 'box': expected another body than body, or none: the "
           "world (joint 'j')"},
      Case{"name = 'j'\nbody = 'post'\npoints_m = [[0, 0, 0]]\n" + springs,
           "joint.body: value 'post': expected a body whose motion is \"free\""},
      Case{"name = 'j'\nbody = 'box'\npoints_m = []\n" + springs,
           "29:12: joint.points_m: value []: expected 1 to 16 vectors, each of 3 numbers"},
      Case{"name = 'j'\nbody = 'box'\npoints_m = [[0, 0]]\n" + springs,
           "joint.points_m: value [0, 0]: expected 1 to 16 vectors, each of 3 numbers"},
      Case{"name = 'j'\nbody = 'box'\npoints_m = [0, 0, 0]\n" + springs,
           "joint.points_m: value 0: expected 1 to 16 vectors, each of 3 numbers"},
      Case{"name = 'j'\nbody = 'box'\njoined_to = 'thread'\npoints_m = [[0.05, 0, 0.03]]\n" +
               springs,
           "expected points within 0.01 m of a node of body 'thread': [0.05, 0, 0.03] is 0.03 m "
           "from the nearest (joint 'j')"},
      Case{"name = 'j'\nbody = 'box'\npoint_m = [[0, 0, 0]]\n" + springs,
           "`point_m`: did you mean `points_m`? (joint 'j')"},
      Case{"name = 'j'\nbody = 'box'\npoints_m = [[0, 0, 0]]\nstiffness_N_per_m = 0\n",
           "joint.stiffness_N_per_m: value 0: expected a number from 1e-9"},
      Case{"name = 'j'\nbody = 'box'\npoints_m = [[0, 0, 0]]\ncollide = true\n" + springs,
           "joint.collide: value true: expected no such key here"},
      Case{"name = 'j'\nbody = 'box'\npoints_m = [[0, 0, 0]]\n" + springs +
               "[[joint]]\nname = 'j'\nbody = 'box'\npoints_m = [[0, 0, 0]]\n" + springs,
           "joint.name: value 'j': expected a name that nothing else of its sort has"});
  const std::string refusal = refusal_of(kBodies + bad.text);
  INFO(refusal);
  CHECK(refusal.find(bad.says) != std::string::npos);
  CHECK(refusal.find('\n') == std::string::npos);
}

}  // namespace
}  // namespace stillgrid::scene::joint_scene_test
