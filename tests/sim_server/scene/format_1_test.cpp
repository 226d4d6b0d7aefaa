#include <catch2/catch.hpp>
#include <string>

#include "shared/files/old_names.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "tests/sim_server/scene/full_scene.hpp"
#include "tests/sim_server/scene/temporary_scene.hpp"

namespace stillgrid::scene::format_1_test {

namespace {

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at))
    text.replace(at, from.size(), to);
  return text;
}

/// The full scene as it was written in format 1.
std::string full_scene_of_format_1() {
  std::string text = replaced(std::string(kFullScene), "format = 2", "format = 1");
  for (const auto& [before, now] : files::kOldSceneKeys)
    text = replaced(text, std::string(now), std::string(before));
  return text;
}

/// Stiffnesses and damping of a body's springs; of what has none, nothing.
std::vector<double> stiffnesses_of(const bodies::BodyDescription& body) {
  return std::visit(
      [](const auto& shape) -> std::vector<double> {
        if constexpr (requires { shape.springs; }) {
          const auto& springs = shape.springs;
          std::vector<double> found{springs.structural_stiffness_N_per_m,
                                    springs.bend_stiffness_N_per_m,
                                    springs.spring_damping_N_s_per_m};
          if constexpr (requires { springs.shear_stiffness_N_per_m; })
            found.push_back(springs.shear_stiffness_N_per_m);
          return found;
        } else {
          return {};
        }
      },
      body.shape);
}

}  // namespace

TEST_CASE("A scene of format 1 is read as the same of format 2, and each old key told once",
          "[format_1]") {
  const SceneDescription old = scene_of(full_scene_of_format_1());
  const SceneDescription now = scene_of(std::string(kFullScene));
  REQUIRE(old.materials.size() == now.materials.size());
  for (std::size_t i = 0; i < now.materials.size(); ++i) {
    CHECK(old.materials[i].contact_stiffness_N_per_m == now.materials[i].contact_stiffness_N_per_m);
    CHECK(old.materials[i].contact_damping_N_s_per_m == now.materials[i].contact_damping_N_s_per_m);
  }
  REQUIRE(old.bodies.size() == now.bodies.size());
  for (std::size_t i = 0; i < now.bodies.size(); ++i) {
    CHECK(stiffnesses_of(old.bodies[i]) == stiffnesses_of(now.bodies[i]));
    CHECK(old.bodies[i].mass_kg == now.bodies[i].mass_kg);
  }
  CHECK(now.warnings.empty());
  REQUIRE(old.warnings.size() == files::kOldSceneKeys.size());
  for (std::size_t i = 0; i < files::kOldSceneKeys.size(); ++i)
    CHECK_THAT(old.warnings[i], Catch::Contains(std::string(files::kOldSceneKeys[i].before) +
                                                " is of format 1: format 2 calls it " +
                                                std::string(files::kOldSceneKeys[i].now)));
  CHECK_THAT(old.warnings[0], Catch::Contains(":18:1: "));
}

TEST_CASE("A refused scene of format 1 is told where it is wrong and which keys were renamed",
          "[format_1]") {
  CHECK_THROWS_WITH(
      scene_of("format = 1\n[[material]]\nname = 'm'\ncontact_stiffness_N_m = 0\n"
               "contact_damping_N_s_m = 1"),
      Catch::Contains(":4:25: material.contact_stiffness_N_per_m: value 0") &&
          Catch::EndsWith("; of format 1: contact_stiffness_N_m, which format 2 calls "
                          "contact_stiffness_N_per_m, contact_damping_N_s_m, which format 2 calls "
                          "contact_damping_N_s_per_m"));
  CHECK_THROWS_WITH(scene_of("format = 1\n[world]\ncontact_stiffness_N_m = 3"),
                    Catch::Contains(":3:1: world.contact_stiffness_N_per_m: value 3") &&
                        Catch::Contains("of format 1: contact_stiffness_N_m"));
  CHECK_THROWS_WITH(scene_of("format = 1\n[world]\nspeed = 3"),
                    !Catch::Contains("which format 2 calls"));
}

TEST_CASE("A key of format 1 in a scene of format 2 is refused by the name of today",
          "[format_1]") {
  for (const auto& [before, now] : files::kOldSceneKeys)
    CHECK_THROWS_WITH(
        scene_of("format = 2\n[[material]]\nname = 'm'\nadhesion = { " + std::string(before) +
                 " = 1 }"),
        Catch::EndsWith(":4:14: material.adhesion." + std::string(before) +
                        ": value 1: expected no such key: format 2 calls it " + std::string(now)));
}

TEST_CASE("A key under both its names is refused in either format", "[format_1]") {
  const std::string both =
      "\nmaterial = [{ name = 'm', contact_stiffness_N_m = 1, contact_stiffness_N_per_m = 1 }]";
  CHECK_THROWS_WITH(scene_of("format = 1" + both),
                    Catch::EndsWith(":2:27: material.contact_stiffness_N_m: value 1: expected "
                                    "contact_stiffness_N_per_m alone, which is the same key"));
  CHECK_THROWS_WITH(scene_of("format = 2" + both),
                    Catch::EndsWith("format 2 calls it contact_stiffness_N_per_m"));
}

}  // namespace stillgrid::scene::format_1_test
