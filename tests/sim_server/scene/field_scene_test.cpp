#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <string>

#include "proto/distance_field.hpp"
#include "shared/collision/distance_field.hpp"
#include "sim_server/bodies/kinds/body_in_world.hpp"
#include "sim_server/scene/build_world.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "tests/test_folder.hpp"

namespace stillgrid::scene::field_scene_test {
namespace {

using Eigen::Vector3d;

/// A brick of 4 x 2 x 1 whose lowest corner is the origin.
constexpr const char* kBrick =
    "v 0 0 0\nv 4 0 0\nv 0 2 0\nv 4 2 0\nv 0 0 1\nv 4 0 1\nv 0 2 1\nv 4 2 1\n"
    "f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 7 3\n"
    "f 2 4 8\nf 2 8 6\n";

// What follows a body's keys stands on line 11.
const std::string kMaterial =
    "format = 2\nmaterial = [{ name = 'm', contact_stiffness_N_per_m = 100.0 }]\n";
std::string body_with(const std::string& motion) {
  return "[[body]]\nname = 'b'\nkind = 'mesh'\nmaterial = 'm'\n" + motion +
         "scale = 0.01\nfile = 'brick.obj'\n";
}
const std::string kBody = body_with("mass_kg = 2.0\n");
const std::string kStill = body_with("motion = 'static'\n");
const std::string kContact = "contact = 'field'\n";
const std::string kSpheres = "contact = 'spheres'\n";
const std::string kField = kContact + "field = { cell_m = 0.001 }\n";

struct Scenes {
  tests::TestFolder folder;
  Scenes() { folder.write("brick.obj", kBrick); }
  [[nodiscard]] SceneDescription load(const std::string& text) const {
    return load_scene(folder.write("scene.toml", text));
  }
  [[nodiscard]] std::string refusal(const std::string& text) const {
    try {
      (void)load(text);
    } catch (const toml::SceneError& error) {
      const std::string line = error.what(), file = (folder.path / "scene.toml").string() + ":";
      return line.starts_with(file) ? line.substr(file.size()) : "names no file: " + line;
    }
    return "";
  }
};

const collision::DistanceField& field_of(const SceneDescription& scene) {
  return *bodies::field_of(scene.bodies.at(0));
}

}  // namespace

TEST_CASE("A mesh that is met through its field has points where it moves, and no spheres",
          "[field_scene]") {
  const Scenes scenes;
  const bool is_static = GENERATE(false, true);
  const SceneDescription scene = scenes.load(
      kMaterial + (is_static ? kStill : kBody) + kField +
      "position_m = [1, 2, 3]\norientation_xyzw = [0, 0, 0.7071, 0.7071]\nstiffness_scale = 2.0\n");
  const bodies::World world = build_world(scene);
  REQUIRE(world.fields.size() == 1);
  CHECK(world.static_spheres.empty());
  CHECK(world.spheres.empty() == is_static);
  for (const bodies::SphereBinding& sphere : world.spheres) {
    CHECK(sphere.is_field_point);
    CHECK(sphere.rigid == 0);
    CHECK(sphere.radius_m < 1e-3);
  }
  const bodies::FieldBody& met = world.fields[0];
  CHECK(met.body == 0);
  CHECK(met.rigid == (is_static ? -1 : 0));
  CHECK(world.materials[static_cast<std::size_t>(met.material)].stiffness_N_per_m == 200.0);
  // A quarter turn about z: the middle of the brick's far face, and outwards there.
  const Vector3d face_m = Vector3d(1 - 0.01, 2 + 0.04, 3.005);
  if (!is_static) {
    CHECK(met.position_m.isZero(0.0));
    CHECK(met.orientation.coeffs() == Eigen::Quaterniond::Identity().coeffs());
  }
  const Vector3d origin_m = is_static ? met.position_m : world.rigid_bodies[0].position_m;
  const Eigen::Quaterniond turn = is_static ? met.orientation : world.rigid_bodies[0].orientation;
  const auto contact = collision::field_contact(
      met.field->view(), turn.conjugate() * (face_m + Vector3d(0, 0.003, 0) - origin_m), 0.005);
  REQUIRE(contact);
  CHECK(contact->depth_m == Approx(0.002).margin(1e-7));
  CHECK((turn * contact->normal).isApprox(Vector3d::UnitY(), 1e-4));
  if (is_static) return;
  const bodies::RigidBody& rigid = world.rigid_bodies[0];
  CHECK(rigid.inertia_kg_m2.isApprox(2.0 * Vector3d(5e-4, 17e-4, 20e-4) / 12.0));
  const double corner_m = 0.005 * std::sqrt(16.0 + 4.0 + 1.0);
  CHECK(rigid.bounding_radius_m >= corner_m - 1e-12);
  CHECK(rigid.bounding_radius_m < 1.001 * corner_m);
}

TEST_CASE("A field reaches as far as the largest sphere that may meet it", "[field_scene]") {
  const Scenes scenes;
  const auto meets = [&](const std::string& more, double radius_m) {
    const SceneDescription scene = scenes.load(kMaterial + kBody + kField + more);
    // Along each axis, from a face to the centre of a sphere that just touches it.
    for (int axis = 0; axis < 3; ++axis)
      for (const double side : {-1.0, 1.0}) {
        Vector3d at_m = Vector3d::Zero();
        at_m[axis] = side * (Vector3d(0.005, 0.01, 0.02).reverse()[axis] + radius_m);
        if (!collision::field_contact(field_of(scene).view(), at_m, radius_m)) return false;
      }
    return true;
  };
  CHECK(meets("", 0.005));  // the tool that a scene has without a word
  CHECK_FALSE(meets("", 0.02));
  CHECK(meets("[tool]\nradius_m = 0.02\n", 0.02));
  CHECK(
      meets("[[body]]\nname = 'c'\nkind = 'sphere'\nmaterial = 'm'\nmass_kg = 1\n"
            "radius_m = 0.03\n",
            0.03));
}

TEST_CASE("A note says what a field takes, and memory is reckoned with it", "[field_scene]") {
  const Scenes scenes;
  const SceneDescription scene = scenes.load(kMaterial + kBody + kField);
  REQUIRE(scene.notes.size() == 1);
  const std::string bricks = std::to_string(field_of(scene).shape().fine_count);
  CHECK(scene.notes[0].starts_with("body 'b': field of " + bricks + " bricks, "));
  CHECK(scene.notes[0].find(" MiB, cell 0.001 m, ") != std::string::npos);
  CHECK(bodies::counts_of(scene.bodies[0]).field_bytes ==
        static_cast<double>(field_of(scene).bytes()));
}

TEST_CASE("A wider band makes more of a field fine", "[field_scene]") {
  const Scenes scenes;
  const auto bricks = [&](const std::string& band) {
    return field_of(scenes.load(kMaterial + kBody + kContact + "field = { cell_m = 0.0005" + band +
                                " }\n"))
        .shape()
        .fine_count;
  };
  CHECK(bricks(", band_m = 0.001") < bricks(", band_m = 0.004"));
  // A radius of the tool and two cells: so far is its proxy from the surface.
  CHECK(bricks("") == bricks(", band_m = 0.006"));
}

TEST_CASE("A map of stiffness is in the mesh's frame, wherever the body stands, and does no work",
          "[field_scene]") {
  const Scenes scenes;
  // On the far face along x, which is not the longest side's principal axis of the frame inside.
  std::string map = "x_m,y_m,z_m,stiffness_N_per_m\n";
  for (int i = 0; i <= 10; ++i)
    for (int j = 0; j <= 5; ++j)
      map += "0.04," + std::to_string(0.002 * i) + "," + std::to_string(0.002 * j) + "," +
             std::to_string(40 + 30 * i) + "\n";
  scenes.folder.write("map.csv", map);
  const SceneDescription scene =
      scenes.load(kMaterial + kStill + kContact +
                  "field = { cell_m = 0.0005, stiffness_map = 'map.csv', offset_m = 0.001 }\n"
                  "position_m = [1, 2, 3]\norientation_xyzw = [0, 0, 0.7071, 0.7071]\n"
                  "stiffness_scale = 2.0\n");
  CHECK(scene.notes.at(0).find(", 40 to 340 N/m by 66 places, elsewhere 200 N/m") !=
        std::string::npos);
  const bodies::World world = build_world(scene);
  const bodies::FieldBody& met = world.fields.at(0);
  constexpr double kRadius_m = 0.003;
  const auto force_N = [&](const Vector3d& in_mesh_m) -> Vector3d {
    const Vector3d at_m(1 - in_mesh_m.y(), 2 + in_mesh_m.x(), 3 + in_mesh_m.z());
    const auto contact = collision::field_contact(
        met.field->view(), met.orientation.conjugate() * (at_m - met.position_m), kRadius_m);
    REQUIRE(contact);
    const Vector3d normal = met.orientation * contact->normal;
    return world.materials[static_cast<std::size_t>(met.material)].stiffness_N_per_m *
           contact->stiffness_scale * std::max(contact->depth_m, 0.0) * normal;
  };
  // The offset is a millimetre more of depth; the force of k(y) d^2 / 2 along x is k d.
  for (const double y_m : {0.004, 0.0071, 0.013}) {
    const Vector3d pressed_N = force_N({0.042, y_m, 0.005});
    CHECK(pressed_N.y() == Approx((40.0 + 15e3 * y_m) * 0.002).epsilon(0.02));
    CHECK(pressed_N.x() ==
          Approx(0.5 * 15e3 * 0.002 * 0.002).epsilon(0.05));  // to where it is soft
  }
  double work_J = 0.0, most_J = 0.0;
  const auto way = [](double turn) {
    return Vector3d(0.0420 + 0.0015 * std::cos(turn), 0.009 + 0.006 * std::sin(turn),
                    0.005 + 0.001 * std::sin(2.0 * turn));
  };
  constexpr int kSteps = 4000;
  for (int i = 0; i < kSteps; ++i) {
    const double turn = 2.0 * M_PI / kSteps;
    const Vector3d step_m = way((i + 1) * turn) - way(i * turn);
    const double step_J =
        force_N(way((i + 0.5) * turn)).dot(Vector3d(-step_m.y(), step_m.x(), step_m.z()));
    work_J += step_J;
    most_J += std::abs(step_J);
  }
  CHECK(std::abs(work_J) < 1e-4 * most_J);
}

TEST_CASE("The surface of a static body with a field stands where its mesh does", "[field_scene]") {
  const Scenes scenes;
  const SceneDescription scene =
      scenes.load(kMaterial + kStill + kField + "position_m = [0.1, 0.2, 0.3]\n");
  const auto surfaces = bodies::rest_surfaces(scene.bodies, build_world(scene));
  REQUIRE(surfaces.size() == 1);
  CHECK(surfaces[0].triangles.size() == 12);
  REQUIRE(surfaces[0].vertices.size() == 8);
  for (const bodies::SurfacePoint& vertex : surfaces[0].vertices) {
    CHECK(vertex.count == 0);
    const Vector3d from_m = vertex.still_m - Vector3d(0.12, 0.21, 0.305);
    CHECK(from_m.cwiseAbs().isApprox(Vector3d(0.02, 0.01, 0.005)));
  }
}

TEST_CASE("The surface of a moving body with a field goes with its points", "[field_scene]") {
  const Scenes scenes;
  const SceneDescription scene = scenes.load(kMaterial + kBody + kField);
  const bodies::World world = build_world(scene);
  const auto surfaces = bodies::rest_surfaces(scene.bodies, world);
  REQUIRE(surfaces.size() == 1);
  for (const bodies::SurfacePoint& vertex : surfaces[0].vertices) {
    REQUIRE(vertex.count > 3);
    Vector3d at_m = Vector3d::Zero();
    for (std::size_t i = 0; i < static_cast<std::size_t>(vertex.count); ++i)
      at_m += vertex.weights[i] *
              world.spheres[static_cast<std::size_t>(vertex.spheres[i])].rest_position_m;
    CHECK((at_m - Vector3d(0.02, 0.01, 0.005)).cwiseAbs().isApprox(Vector3d(0.02, 0.01, 0.005)));
  }
}

TEST_CASE("A fault in the keys of a field is refused where it stands", "[field_scene]") {
  const Scenes scenes;
  struct Fault {
    std::string keys, refusal;
  };
  const std::string springs =
      "spring_stiffness_N_per_m = { structural = 10.0, shear = 5.0 }\nlattice_m = 0.01\n";
  const Fault faults[] = {
      {"contact = 'auto'\n", "10:11: body.contact: value 'auto': expected one of field, spheres"},
      {"field = { cell_m = 0.001 }\nspheres = { tolerance_m = 0.002 }\n",
       "10:9: body.field: value {...}: expected no such key of a mesh that is met by spheres"},
      {kSpheres, "3:1: body.spheres.tolerance_m: value missing: expected a number from 1e-9"},
      {"force_error = 0.1\n",
       "10:15: body.force_error: value 0.1: expected no such key: write field = { cell_m = ... }"},
      {"normalise = { tool_radius_m = 0.005, press_depth_m = 0.002 }\n",
       "10:13: body.normalise: value {...}: expected no such key: the force at rest is stiffness "
       "times depth whatever the spheres (body 'b')"},
      {"spheres = { feel = '1jnd' }\n",
       "10:20: body.spheres.feel: value '1jnd': expected no such key: write tolerance_m, or no "
       "`spheres` for a field (body 'b')"},
      {kContact + "field = { cell_m = 1e-6 }\n",
       "11:20: body.field.cell_m: value 1e-06: expected a thousandth to a tenth of the mesh's"},
      {kContact + "field = { cell_m = 0.005 }\n",
       "11:20: body.field.cell_m: value 0.005: expected a thousandth to a tenth of the mesh's"},
      {kContact + "field = { cell_m = 0.001, band_m = 0.05 }\n",
       "11:36: body.field.band_m: value 0.05: expected at most the mesh's longest side"},
      {kContact + "field = { cell_m = 0.001, cells = 3 }\n",
       "11:27: body.field.cells: value 3: unknown key `cells`: did you mean `cell_m`? (body 'b')"},
      {kContact + "field = { cell_m = 0.001, offset_m = 0.005 }\n",
       "11:38: body.field.offset_m: value 0.005: expected at most a tenth of the mesh's"},
      {kContact + "field = { cell_m = 0.001, offset_m = 0.001 }\n",
       "11:38: body.field.offset_m: value 0.001: expected no such key of a body that moves"},
      {kContact + "field = { cell_m = 0.001, stiffness_map = 'none.csv' }\n",
       "11:43: body.field.stiffness_map: value 'none.csv': expected a map of stiffness; " +
           (scenes.folder.path / "none.csv").string() + ": cannot be read"},
      {kContact + "field = { cell_m = 0.001, stiffness_map = 'bad.csv' }\n",
       "11:43: body.field.stiffness_map: value 'bad.csv': expected a map of stiffness; " +
           (scenes.folder.path / "bad.csv").string() + ":3: column stiffness_N_per_m: value '-5'"},
      {kContact + "field = { cell_m = 0.001, stiffness_map = 'far.csv' }\n",
       "11:43: body.field.stiffness_map: value 'far.csv': expected places of this mesh at this "
       "scale; 1 of 2 lie farther from its box than a tenth"},
      {kContact + "field = { cell_m = 0.001, stiffness_map = 'stiff.csv' }\n",
       "11:1: body.field.stiffness_map: value 200000: expected at most 1000 times the body's own "
       "100 N/m"},
      {kField + "spheres = { tolerance_m = 0.002 }\n",
       "12:11: body.spheres: value {...}: expected no such key beside contact = \"field\""},
      {kField + springs,
       "10:11: body.contact: value 'field': expected \"spheres\": a soft mesh deforms, which no"},
      {kContact + "field = { cell_m = 0.00005, band_m = 0.01 }\n",
       "11:1: body.field.cell_m: value 5e-05: expected cells of a field that can be held; a field "
       "of at least 256 MiB: expected at most 256 MiB"},
  };
  scenes.folder.write("far.csv", "x_m,y_m,z_m,stiffness_N_per_m\n0,0,0,5\n40,20,0,5\n");
  scenes.folder.write("stiff.csv", "x_m,y_m,z_m,stiffness_N_per_m\n0,0,0,2e5\n");
  scenes.folder.write("bad.csv", "x_m,y_m,z_m,stiffness_N_per_m\n0,0,0,5\n0,0,0,-5\n");
  for (const Fault& fault : faults) {
    const std::string line = scenes.refusal(kMaterial + kBody + fault.keys);
    INFO(line);
    CHECK(line.substr(0, fault.refusal.size()) == fault.refusal);
    CHECK(line.find('\n') == std::string::npos);
  }
}

TEST_CASE("A mesh that keeps its shape has a field by default, of cells that follow from lengths",
          "[field_scene]") {
  const Scenes scenes;
  const auto cell_m = [](const SceneDescription& scene) {
    return double{field_of(scene).shape().brick_m} / proto::kBrickCells;
  };
  const std::string body = GENERATE(kBody, kStill);
  const SceneDescription scene = scenes.load(kMaterial + body);
  CHECK(cell_m(scene) == Approx(0.04 / 32.0));  // the brick's longest side
  CHECK(cell_m(scenes.load(kMaterial + body + "[tool]\nradius_m = 0.002\n")) == Approx(0.001));
  CHECK(cell_m(scenes.load(kMaterial + body + "field = { cell_m = 0.002 }\n")) == Approx(0.002));
  CHECK(field_of(scene).words().size() == field_of(scenes.load(kMaterial + body)).words().size());
}

TEST_CASE("A mesh has spheres where they are asked for, or where it deforms", "[field_scene]") {
  const Scenes scenes;
  const std::string spheres = "spheres = { volume_spacing_m = 0.005 }\n";
  const std::string springs =
      "spring_stiffness_N_per_m = { structural = 10.0, shear = 5.0 }\nlattice_m = 0.01\n";
  for (const std::string& keys : {spheres, "contact = 'spheres'\n" + spheres, spheres + springs,
                                  kSpheres + spheres + springs}) {
    const SceneDescription scene = scenes.load(kMaterial + kBody + keys);
    CHECK(bodies::field_of(scene.bodies.at(0)) == nullptr);
    CHECK(bodies::balls_of(scene.bodies[0]).size() == 64);
  }
}

TEST_CASE("A scene has at most as many fields as a segment", "[field_scene]") {
  const Scenes scenes;
  std::string text = kMaterial;
  for (unsigned i = 0; i <= proto::kMaxFields; ++i) {
    text += "[[body]]\nname = '" + std::to_string(i) +
            "'\nkind = 'rigid_box'\nsize_m = [0.1, 0.1, 0.1]\nmotion = 'static'\nmaterial = 'm'\n";
  }
  CHECK(scenes.refusal(text).find("body.kind: value 'rigid_box': expected at most 512 fields") !=
        std::string::npos);
}

}  // namespace stillgrid::scene::field_scene_test
