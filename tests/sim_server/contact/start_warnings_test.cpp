#include "sim_server/contact/start_warnings.hpp"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::contact::start_warnings_test {
namespace {

/// What is said of a scene; bodies are named "a", "b", ... and stand at lines 1, 2, ...
std::vector<std::string> warnings_of(std::vector<bodies::BodyDescription> bodies) {
  unsigned line = 0;
  for (bodies::BodyDescription& body : bodies) {
    body.name = std::string(1, static_cast<char>('a' + line));
    body.line = ++line;
  }
  scene::SceneDescription scene =
      sim_server::scene_of(std::move(bodies), sim_server::material_of(100.0));
  scene.tool = {{Eigen::Vector3d::Zero(), 0.005}};
  return start_warnings(scene, scene::build_world(scene), "s.toml");
}

void check_one(const std::vector<std::string>& warnings, const std::string& where,
               const std::string& what) {
  REQUIRE(warnings.size() == 1);
  INFO(warnings[0]);
  CHECK(warnings[0].find("s.toml:" + where + ": body ") == 0);
  CHECK(warnings[0].find(what) != std::string::npos);
}

TEST_CASE("Of a scene that a hand can hold nothing is said", "[start_warnings]") {
  CHECK(
      warnings_of({sim_server::floor_at(0.0), sim_server::sphere({0, 0, 0.02}, 0.02, 0.1),
                   sim_server::sphere({0, 0, 0.055}, 0.02, 1),
                   sim_server::box({0.3, 0, 0.05}, {0.1, 0.1, 0.1}, 1.0, {0.02, 0.01}),
                   sim_server::moving(sim_server::sheet({20, 20}, 0.01, 1e-4, 100.0), {0, 0, 2.0})})
          .size() == 1);  // the sheet lies in the floor's plane and in the ball
  CHECK(warnings_of({sim_server::floor_at(-0.1), sim_server::sphere({0, 0, 0.02}, 0.02, 0.1)})
            .empty());
}

TEST_CASE("A body behind a plane's normal is named with the plane", "[start_warnings]") {
  check_one(warnings_of({sim_server::floor_at(0.0), sim_server::sphere({0, 0, -0.3}, 0.02, 0.1)}),
            "2", "'b': lies 0.3 m below plane 'a', behind its normal");
  bodies::BodyDescription still = sim_server::sphere({0, 0, -0.3}, 0.02, 0.1);
  still.motion = bodies::Motion::kStatic;
  CHECK(warnings_of({sim_server::floor_at(0.0), still}).empty());
}

TEST_CASE("Bodies that overlap deeply at the start are named, a line a pair", "[start_warnings]") {
  check_one(warnings_of({sim_server::sphere({0, 0, 0}, 0.02, 0.1),
                         sim_server::sphere({0.02, 0, 0}, 0.02, 0.1)}),
            "1", "'a': overlaps body 'b' by 0.02 m at the start");
  CHECK(warnings_of({sim_server::sphere({0, 0, 0}, 0.02, 0.1),
                     sim_server::sphere({0.035, 0, 0}, 0.02, 0.1)})
            .empty());
  bodies::BodyDescription still = sim_server::sphere({0.01, 0, 0}, 0.02, 0.1);
  still.motion = bodies::Motion::kStatic;
  check_one(warnings_of({sim_server::sphere({0, 0, 0}, 0.02, 0.1), still}), "1",
            "overlaps body 'b' by 0.03 m");
  check_one(warnings_of({sim_server::box({0, 0, 0}, {0.1, 0.1, 0.1}, 1.0, {0.02, 0.01}),
                         sim_server::box({0.05, 0, 0}, {0.1, 0.1, 0.1}, 1.0, {0.02, 0.01})}),
            "1", "overlaps body 'b' by ");
}

TEST_CASE("Sizes, speeds and places that no hand-held scene has are named", "[start_warnings]") {
  check_one(warnings_of({sim_server::sheet({20, 20}, 10.0, 1e-4, 100.0)}), "1", "is 210 m long");
  check_one(warnings_of({sim_server::sphere({0, 0, 0}, 1e-5, 0.1)}), "1", "is 2e-05 m long");
  check_one(
      warnings_of({sim_server::moving(sim_server::sphere({0, 0, 0}, 0.02, 0.1), {0, 200, 0})}), "1",
      "moves at 200 m/s");
  check_one(warnings_of({sim_server::sphere({0, 5000, 0}, 0.02, 0.1)}), "1",
            "is 5e+03 m from the origin");
}

TEST_CASE("A cover that another sphere passes through is named", "[start_warnings]") {
  const auto box = [](const bodies::SpherePacking& spheres) {
    return sim_server::box({0, 0, 0}, {0.1, 0.1, 0.1}, 1.0, spheres);
  };
  check_one(warnings_of({box({0.02, 0.008})}), "1",
            "'a': has holes: a sphere of radius 0.005 m passes between its spheres: expected "
            "spacing_m at most their radius, 0.008");
  CHECK(warnings_of({box({0.02, 0.01})}).empty());
  check_one(warnings_of({box({0.02, 0.01}), sim_server::sphere({0.2, 0, 0}, 0.004, 0.1)}), "1",
            "a sphere of radius 0.004 m");
  CHECK(warnings_of({box({}), sim_server::sphere({0.2, 0, 0}, 0.004, 0.1)}).empty());
}

TEST_CASE("Covers whose spheres stand farther apart than their radius are named by a check",
          "[start_warnings]") {
  const auto lines_of = [](const bodies::SpherePacking& spheres) {
    const scene::SceneDescription scene =
        sim_server::scene_of({sim_server::box({0, 0, 0}, {0.1, 0.1, 0.1}, 1.0, spheres)},
                             sim_server::material_of(100.0));
    return cover_warnings(scene, "s.toml");
  };
  REQUIRE(lines_of({0.02, 0.01}).size() == 1);
  CHECK_THAT(lines_of({0.02, 0.01})[0],
             Catch::Contains("spacing_m 0.02 is greater than radius_m 0.01: there may be dips"));
  CHECK(lines_of({0.01, 0.01}).empty());
  CHECK(lines_of({}).empty());
}

TEST_CASE("A mass that no hand moves is named", "[start_warnings]") {
  check_one(warnings_of({sim_server::sphere({0, 0, 0}, 0.1, 100.0)}), "1", "mass_kg 100: ");
  CHECK(warnings_of({sim_server::sphere({0, 0, 0}, 0.1, 50.0)}).empty());
}

TEST_CASE("Materials and tools that no hand feels or holds are named", "[start_warnings]") {
  const auto said = [](double stiffness_N_per_m, double friction, double tool_m, double scale) {
    scene::SceneDescription scene = sim_server::scene_of(
        {sim_server::floor_at(0.0)}, sim_server::material_of(stiffness_N_per_m));
    scene.materials[0].friction = friction;
    scene.tool = {{Eigen::Vector3d::Zero(), tool_m}};
    scene.device.scale = scale;
    std::string lines;
    for (const std::string& line : start_warnings(scene, scene::build_world(scene), "s.toml"))
      lines += line.substr(0, line.find(": ", line.find(": ") + 2)) + "\n";
    return lines;
  };
  const std::string material = "s.toml: material 'test'\n", tool = "s.toml: tool\n";
  CHECK(said(1.0, 2.0, 0.1, 1.0).empty());
  CHECK(said(1e6, 0.0, 0.1, 1.0).empty());
  CHECK(said(0.5, 0.0, 0.005, 1.0) == material);
  CHECK(said(1e7, 0.0, 0.005, 1.0) == material);
  CHECK(said(100.0, 30.0, 0.005, 1.0) == material);
  CHECK(said(100.0, 0.0, 5.0, 1.0) == tool);
  CHECK(said(100.0, 0.0, 5.0, 100.0).empty());  // a world a hundred times as large
  CHECK(said(1e7, 30.0, 5.0, 1.0) == tool + material + material);
}

TEST_CASE("Ten lines are said at most, and how many more there are", "[start_warnings]") {
  std::vector<bodies::BodyDescription> bodies;
  bodies.reserve(25);
  for (int i = 0; i < 25; ++i)
    bodies.push_back(
        sim_server::moving(sim_server::sphere({0.1 * i, 0, 0}, 0.02, 0.1), {0, 200, 0}));
  const std::vector<std::string> warnings = warnings_of(bodies);
  REQUIRE(warnings.size() == 11);
  CHECK(warnings.back() == "s.toml: and 15 more of the kind");
}

}  // namespace
}  // namespace stillgrid::contact::start_warnings_test
