#include "shared/rendering/touched_statics.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <tuple>

#include "shared/rendering/placed_tool.hpp"
#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::rendering::touched_statics_test {
namespace {

/// What is told of a touched sphere, in an order of its own.
auto told(const TouchedSphere& sphere) {
  const auto numbers = [](const Eigen::Vector3d& v) { return std::tuple(v.x(), v.y(), v.z()); };
  return std::tuple(sphere.tool_sphere, sphere.number, sphere.body, sphere.material,
                    sphere.radius_m, sphere.presence, numbers(sphere.position_m),
                    numbers(sphere.velocity_m_s));
}

auto all_told(const TouchedSpheres& touched) {
  std::vector<decltype(told(touched.spheres[0]))> spheres;
  for (const TouchedSphere& sphere : touched.all()) spheres.push_back(told(sphere));
  std::sort(spheres.begin(), spheres.end());
  return spheres;
}

/// A scene of `count` static spheres whose radii span two decades, and a tool of unlike spheres.
publication::StaticScene scattered(std::mt19937_64& random, std::size_t count, float origin_m) {
  std::uniform_real_distribution<float> place_m(-0.05F, 0.05F), decade(-3.5F, -1.5F);
  publication::StaticScene scene = plain_scene(500.0F, 0.005F);
  scene.tool.push_back({{0.004F, -0.003F, 0.01F}, 0.0021F});
  for (std::size_t i = 0; i < count; ++i) {
    scene.spheres.push_back(collision::static_sphere(
        {origin_m + place_m(random), origin_m + place_m(random), origin_m + place_m(random)},
        std::pow(10.0F, decade(random))));
    scene.spheres.back().body = static_cast<std::uint32_t>(i / 5);
  }
  scene.spheres.front().newest.position_m = {NAN, NAN, NAN};
  return scene;
}

TEST_CASE("Static spheres are those that trying the grid's finds, at any width of the tool",
          "[touched_statics]") {
  const float origin_m = GENERATE(0.0F, -3.0F, 200.0F);
  std::size_t touched_in_all = 0, beyond = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    std::mt19937_64 random(seed);
    const PublishedScene scene(scattered(random, 40 + 20 * seed, origin_m), {}, 33'000'000);
    const publication::SceneView& view = scene.view();
    std::uniform_real_distribution<double> place_m(-0.05, 0.05), decade(-5.0, -1.3);
    for (int i = 0; i < 400; ++i) {
      ToolSpheres spheres;
      ToolPose pose;
      pose.position_m = Eigen::Vector3d(place_m(random), place_m(random), place_m(random)).array() +
                        double{origin_m};
      const auto tool = place_tool(view.scene(), pose, spheres);
      const double wider_m = i % 4 == 0 ? 0.0 : std::pow(10.0, decade(random));
      for (PlacedToolSphere& sphere : tool) sphere.radius_m += wider_m;
      TouchedSpheres listed, expected;
      gather_statics(view.touch_lists(), view.static_grid(), tool, listed);
      gather_touched(view.static_grid(), {}, tool, expected);
      if (all_told(listed) != all_told(expected))
        FAIL("seed " << seed << ": " << listed.count << " spheres, expected " << expected.count);
      touched_in_all += listed.count;
      beyond += wider_m > 0.01 ? 1U : 0U;
      CHECK(std::all_of(listed.all().begin(), listed.all().end(),
                        [](const TouchedSphere& sphere) { return sphere.is_static; }));
    }
  }
  CHECK(touched_in_all > 10000);
  CHECK(beyond > 100);
}

TEST_CASE("Among dense static spheres a large tool is held as by the grid's", "[touched_statics]") {
  publication::StaticScene fixed = plain_scene(500.0F, 0.03F);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<float> off_m(-2e-4F, 2e-4F);
  for (int z = 0; z < 40; ++z)
    for (int y = -20; y < 20; ++y)
      for (int x = -20; x < 20; ++x)
        fixed.spheres.push_back(
            collision::static_sphere({2e-3F * static_cast<float>(x) + off_m(random),
                                      2e-3F * static_cast<float>(y) + off_m(random),
                                      -2e-3F * static_cast<float>(z) + off_m(random)},
                                     1.4e-3F));
  const PublishedScene scene(fixed, {}, 33'000'000);
  for (const double height_m : {0.0306, 0.0302, 0.0297}) {
    ToolSpheres spheres;
    ToolPose pose;
    pose.position_m = {0.0013, -0.0007, height_m};
    const auto tool = place_tool(scene.view().scene(), pose, spheres);
    TouchedSpheres listed, expected;
    gather_statics(scene.view().touch_lists(), scene.view().static_grid(), tool, listed);
    gather_touched(scene.view().static_grid(), {}, tool, expected);
    REQUIRE(expected.count > 0);
    CHECK(all_told(listed) == all_told(expected));
    CHECK(listed.truncated == expected.truncated);
  }
}

TEST_CASE("More static spheres than a tick may keep are told to be more", "[touched_statics]") {
  publication::StaticScene fixed = plain_scene(500.0F, 0.005F);
  for (std::size_t i = 0; i < TouchedSpheres::kCapacity + 100; ++i)
    fixed.spheres.push_back(
        collision::static_sphere({1e-6F * static_cast<float>(i), 0.0F, 0.0F}, 0.01F));
  const PublishedScene scene(fixed, {}, 33'000'000);
  ToolSpheres spheres;
  TouchedSpheres touched;
  gather_statics(scene.view().touch_lists(), scene.view().static_grid(),
                 place_tool(scene.view().scene(), {}, spheres), touched);
  CHECK(touched.count == TouchedSpheres::kCapacity);
  CHECK(touched.truncated);
}

TEST_CASE("Visits are bounded for all spheres of the tool together, and end with the memory",
          "[touched_statics]") {
  publication::StaticScene fixed = plain_scene(1.0F, 0.05F);
  fixed.tool.assign(proto::kMaxToolSpheres, fixed.tool.at(0));
  for (int i = 0; i < 15625; ++i)
    fixed.spheres.push_back(collision::static_sphere(
        {4e-3F * static_cast<float>(i % 25 - 12), 4e-3F * static_cast<float>(i / 25 % 25 - 12),
         4e-3F * static_cast<float>(i / 625 - 12)},
        2e-3F));
  const PublishedScene scene(fixed, {}, 33'000'000);
  ToolSpheres spheres;
  const auto tool = place_tool(scene.view().scene(), {}, spheres);
  TouchedSpheres touched;
  const auto visits = [&] { return kMaxVisits - touched.visits_left; };
  gather_touched(scene.view().static_grid(), {}, tool, touched);
  CHECK(touched.truncated);
  CHECK(visits() < 2 * TouchedSpheres::kCapacity);  // it is full
  touched.clear();
  gather_statics(scene.view().touch_lists(), scene.view().static_grid(), tool, touched);
  CHECK(touched.truncated);
  CHECK(visits() < 2 * TouchedSpheres::kCapacity);
  touched.clear();
  touched.visits_left = 100;
  gather_touched(scene.view().static_grid(), {}, tool, touched);
  CHECK(touched.truncated);
  CHECK(touched.visits_left == 0);
  CHECK(touched.count <= 100);
}

}  // namespace
}  // namespace stillgrid::rendering::touched_statics_test
