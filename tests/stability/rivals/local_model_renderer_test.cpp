#include "tests/laboratory/rivals/local_model_renderer.hpp"

#include <catch2/catch.hpp>

#include "tests/laboratory/rivals/force_held.hpp"
#include "tests/laboratory/rivals/proxy.hpp"
#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::laboratory::local_model_renderer_test {
namespace {

publication::StaticScene floor_scene() {
  publication::StaticScene scene = rendering::plain_scene(1000.0F, 0.005F);
  scene.planes = {{{0.0F, 0.0F, 1.0F}, 0.0F, 0, 0}};
  return scene;
}

TEST_CASE("A model is made where the tool was that the snapshot was computed with",
          "[local_model_renderer]") {
  rendering::PublishedScene scene(floor_scene(), {}, rendering::kMillisecond_ns);
  LocalModelRenderer renderer(std::make_unique<ForceHeld>());
  const auto tick = [&](std::uint64_t ms) {  // sinks by 0.1 mm a tick, from contact on
    const rendering::ToolPose pose{
        .position_m = {0.0, 0.0, 0.005 - 1e-4 * static_cast<double>(ms)}};
    return renderer.render(scene.view(), pose, ms * rendering::kMillisecond_ns);
  };
  for (std::uint64_t ms = 0; ms < 10; ++ms) CHECK(tick(ms).snapshot_id == 0);
  scene.show({}, {}, 10 * rendering::kMillisecond_ns, 4 * rendering::kMillisecond_ns);
  const rendering::RenderedTick late = tick(10);
  CHECK(late.is_new);
  CHECK(late.force.force_N.z() == Approx(0.4).epsilon(1e-4));
  CHECK_FALSE(late.switch_jump_N);
  CHECK(late.weights.alpha == 1.0);  // for who looks on: the snapshot as it is
  CHECK(tick(11).force.force_N.z() == late.force.force_N.z());
  scene.show({}, {}, 12 * rendering::kMillisecond_ns);  // no sample told: the tool as it is
  const rendering::RenderedTick low_latency = tick(12);
  CHECK(low_latency.force.force_N.z() == Approx(1.2).epsilon(1e-4));
  REQUIRE(low_latency.switch_jump_N);
  CHECK(*low_latency.switch_jump_N == Approx(0.8).epsilon(1e-4));
}

TEST_CASE("Of a sample older than is kept the oldest pose kept stands for it",
          "[local_model_renderer]") {
  PoseHistory history;
  for (std::uint64_t i = 1; i <= PoseHistory::kCapacity + 100; ++i)
    history.push(i, {.position_m = {static_cast<double>(i), 0.0, 0.0}});
  CHECK(history.at(50).position_m.x() == 101.0);
  CHECK(history.at(101).position_m.x() == 101.0);
  CHECK(history.at(300).position_m.x() == 300.0);
  CHECK(history.at(1'000'000).position_m.x() == static_cast<double>(PoseHistory::kCapacity + 100));
}

TEST_CASE("Static spheres and planes are in the patch like moving ones", "[local_model_renderer]") {
  publication::StaticScene fixed = floor_scene();
  fixed.spheres = {collision::static_sphere({0.010F, 0.0F, 0.005F}, 0.01F)};
  rendering::PublishedScene scene(fixed, {0.01F}, rendering::kMillisecond_ns);
  scene.show({{-0.012, 0.0, 0.005}}, 0);
  LocalModelRenderer renderer(std::make_unique<ForceHeld>());
  const rendering::ToolForce force =
      renderer.render(scene.view(), {.position_m = {0.0, 0.0, 0.004}}, 0).force;
  CHECK(force.contacts == 3);
}

TEST_CASE("A new session's first snapshot replaces the model of the old one",
          "[local_model_renderer]") {
  LocalModelRenderer renderer(std::make_unique<Proxy>());
  rendering::PublishedScene first(floor_scene(), {}, rendering::kMillisecond_ns);
  first.show({}, 0);
  rendering::ToolPose pose{.position_m = {0.0, 0.0, 0.01}};
  CHECK(renderer.render(first.view(), pose, 0).force.contacts == 0);
  pose.position_m.z() = -0.02;
  CHECK(renderer.render(first.view(), pose, 0).force.force_N.z() == Approx(25.0).epsilon(1e-4));
  rendering::PublishedScene second(rendering::plain_scene(1000.0F, 0.005F), {},
                                   rendering::kMillisecond_ns);
  CHECK(renderer.render(second.view(), pose, 0).snapshot_id == 0);
  second.show({}, 0);
  CHECK(renderer.render(second.view(), pose, 0).force.contacts == 0);
}

}  // namespace
}  // namespace stillgrid::laboratory::local_model_renderer_test
