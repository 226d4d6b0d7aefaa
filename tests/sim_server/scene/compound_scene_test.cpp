#include <catch2/catch.hpp>
#include <string>

#include "tests/sim_server/scene/full_scene.hpp"
#include "tests/sim_server/scene/temporary_scene.hpp"

namespace stillgrid::scene::compound_scene_test {
namespace {

using Kind = bodies::SolidShape::Kind;

const std::string kBody = R"(format = 2
[[material]]
name = "m"
contact_stiffness_N_per_m = 500.0
[[body]]
name = "b"
kind = "compound"
mass_kg = 0.1
material = "m"
)";

bodies::BodyDescription body_with(const std::string& shapes) {
  return scene_of(kBody + shapes).bodies.at(0);
}

}  // namespace

TEST_CASE("Shapes are read with sizes and poses, about their centre of mass", "[compound_scene]") {
  const bodies::BodyDescription body = body_with(
      "[[body.shape]]\nkind = 'sphere'\nradius_m = 0.02\nposition_m = [0.1, 0, 0]\n"
      "[[body.shape]]\nkind = 'sphere'\nradius_m = 0.02\nposition_m = [0.3, 0, 0]\n");
  const auto& shapes = std::get<bodies::CompoundBody>(body.shape).shapes;
  REQUIRE(shapes.size() == 2);
  CHECK(body.position_m.isApprox(Eigen::Vector3d(0.2, 0.0, 0.0)));
  CHECK(shapes[0].position_m.isApprox(Eigen::Vector3d(-0.1, 0.0, 0.0)));
  CHECK(shapes[0].half_m == Eigen::Vector3d::Constant(0.02));

  const auto kinds = GENERATE(std::pair<std::string, Kind>{"capsule", Kind::kCapsule},
                              std::pair<std::string, Kind>{"cylinder", Kind::kCylinder});
  const auto one = std::get<bodies::CompoundBody>(
      body_with("[[body.shape]]\nkind = '" + kinds.first + "'\nradius_m = 0.02\nlength_m = 0.1\n")
          .shape);
  CHECK(one.shapes.at(0).kind == kinds.second);
  CHECK(one.shapes.at(0).half_m == Eigen::Vector3d(0.02, 0.02, 0.05));
}

TEST_CASE("A box is exact unless spheres are asked for", "[compound_scene]") {
  std::string text = kBody;
  text.replace(text.find("compound"), 8, "rigid_box");
  text += "size_m = [0.1, 0.1, 0.1]\n";
  CHECK(std::holds_alternative<bodies::CompoundBody>(scene_of(text).bodies.at(0).shape));
  text += "spheres = {}\n";
  CHECK(std::holds_alternative<bodies::RigidBoxBody>(scene_of(text).bodies.at(0).shape));
}

TEST_CASE("A fault in a shape is refused where it stands", "[compound_scene]") {
  struct Case {
    std::string text, says;
  };
  const Case bad = GENERATE(
      Case{"", "body.shape: value missing: expected 1 to 64 tables [[body.shape]] (body 'b')"},
      Case{"shape = []\n", "10:9: body.shape: value []: expected 1 to 64 tables"},
      Case{"shape = 3\n", "10:9: body.shape: value 3: expected an array of tables"},
      Case{"[[body.shape]]\nkind = 'cone'\n",
           "11:8: body.shape.kind: value 'cone': expected one of box, sphere, capsule, cylinder "
           "(body 'b')"},
      Case{"[[body.shape]]\nkind = 'box'\n", "body.shape.size_m: value missing"},
      Case{"[[body.shape]]\nkind = 'box'\nsize_m = [0.1, 0.1, -0.1]\n",
           "12:21: body.shape.size_m: value -0.1: expected a number from 1e-9"},
      Case{"[[body.shape]]\nkind = 'box'\nsize_m = [0.1, 0.1, 0.1]\nradius_m = 0.1\n",
           "13:1: body.shape.radius_m: value 0.1: expected no such key here"},
      Case{"[[body.shape]]\nkind = 'capsule'\nradius_m = 0.1\nlength_m = 0.19\n",
           "13:12: body.shape.length_m: value 0.19: expected at least twice radius_m"},
      Case{"[[body.shape]]\nkind = 'sphere'\nradius_m = 0.1\norientation_xyzw = [0, 0, 0, 2]\n",
           "body.shape.orientation_xyzw: value"},
      Case{"[[body.shape]]\nkind = 'cylinder'\nradius_m = 0.1\nlenght_m = 0.19\n",
           "did you mean `length_m`?"});
  CAPTURE(bad.text);
  const std::string refusal = refusal_of(kBody + bad.text);
  CAPTURE(refusal);
  CHECK(refusal.find(bad.says) != std::string::npos);
}

}  // namespace stillgrid::scene::compound_scene_test
