#include "shared/rendering/tool_force.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "shared/collision/contact_law.hpp"
#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::rendering::tool_force_test {
namespace {

TEST_CASE("A plane pushes along its normal with stiffness times depth", "[tool_force]") {
  publication::StaticScene fixed = plain_scene(1000.0F, 0.005F);
  fixed.planes = {{{0.0F, 0.0F, 1.0F}, 0.0F, 0, 0}};
  PublishedScene scene(fixed, {}, kMillisecond_ns);
  scene.show({}, 0);
  SnapshotRenderer renderer(display::Transition::kHold);
  const RenderedTick inside = renderer.render(scene.view(), {.position_m = {0, 0, 0.003}}, 0);
  CHECK(inside.force.force_N.z() == Approx(2.0).epsilon(1e-6));
  CHECK(inside.force.contacts == 1);
  CHECK(renderer.render(scene.view(), {.position_m = {0, 0, 0.006}}, 0).force.contacts == 0);
}

TEST_CASE("Each sphere of a tool adds its contacts, turned with the tool", "[tool_force]") {
  publication::StaticScene fixed = plain_scene(1000.0F, 0.005F);
  fixed.planes = {{{0.0F, 0.0F, 1.0F}, 0.0F, 0, 0}};
  fixed.tool = {{{0.01F, 0.0F, 0.0F}, 0.005F}, {{-0.01F, 0.0F, 0.0F}, 0.005F}};
  PublishedScene scene(fixed, {}, kMillisecond_ns);
  scene.show({}, 0);
  SnapshotRenderer renderer(display::Transition::kHold);
  ToolPose pose{.position_m = {0, 0, 0.004}};
  CHECK(renderer.render(scene.view(), pose, 0).force.contacts == 2);
  pose.orientation = Eigen::AngleAxisd(1.5707963267948966, Eigen::Vector3d::UnitY());
  const ToolForce upright = renderer.render(scene.view(), pose, 0).force;
  CHECK(upright.contacts == 1);
  CHECK(upright.force_N.z() == Approx(11.0).epsilon(1e-4));  // 4 - 10 - 5 = -11 mm
}

TEST_CASE("A static sphere of the scene is felt like a moving one", "[tool_force]") {
  publication::StaticScene fixed = plain_scene(500.0F, 0.005F);
  proto::SphereRecord record{};
  record.radius_m = 0.01F;
  fixed.spheres = {record};
  PublishedScene scene(fixed, {}, kMillisecond_ns);
  scene.show({}, 0);
  SnapshotRenderer renderer(display::Transition::kLinear);
  CHECK(renderer.render(scene.view(), {.position_m = {0.013, 0, 0}}, 0).force.force_N.x() ==
        Approx(1.0).epsilon(1e-5));
}

TEST_CASE("The force on the probe is what the law gives two spheres, whoever asks",
          "[tool_force]") {
  proto::SceneHeader header{};
  header.material_count = 1;
  header.materials[0] = {800.0F, 3.0F, 0.4F, 1e-3F};
  header.tool_slip_speed_m_s = 0.05F;
  TouchedSpheres touched;
  touched.spheres[0] = {{0.0, 0.0, 0.0}, {0.05, -0.02, 0.01}, 0.01, 0, 0, false};
  touched.count = 1;
  const std::array<PlacedToolSphere, 1> tool{{{{0.004, 0.011, 0.003}, 0.006}}};
  const Eigen::Vector3d velocity_m_s(-0.1, 0.03, 0.2);
  const Eigen::Vector3d line_m = tool[0].position_m;
  const collision::ContactMaterial material{800.0, 3.0, 0.4F, 0.05F};
  const Eigen::Vector3d expected_N =
      collision::contact_force_N(material, 0.016 - line_m.norm(), line_m.normalized(),
                                 velocity_m_s - Eigen::Vector3d(0.05, -0.02, 0.01));
  CHECK((tool_force(header, touched, tool, {.velocity_m_s = velocity_m_s}).force_N - expected_N)
            .norm() < 1e-12);
}

TEST_CASE("A material or tool sphere that does not exist adds nothing", "[tool_force]") {
  proto::SceneHeader header{};
  header.material_count = 1;
  header.materials[0] = {800.0F, 0.0F, 0.0F, 1e-3F};
  TouchedSpheres touched;
  touched.spheres[0] = {{0, 0, 0}, {0, 0, 0}, 0.01, 1, 0, false};
  touched.spheres[1] = {{0, 0, 0}, {0, 0, 0}, 0.01, 0, 1, false};
  touched.count = 2;
  const std::array<PlacedToolSphere, 1> tool{{{{0.001, 0, 0}, 0.006}}};
  CHECK(tool_force(header, touched, tool, {}).contacts == 0);
}

TEST_CASE("More contacts than a tick may keep are cut, and said to be", "[tool_force]") {
  const std::size_t count = TouchedSpheres::kCapacity + 100;
  PublishedScene scene(plain_scene(1.0F, 0.005F), std::vector<float>(count, 0.005F),
                       kMillisecond_ns);
  scene.show(std::vector<Eigen::Vector3d>(count, {0.001, 0.0, 0.0}), 0);
  SnapshotRenderer renderer(display::Transition::kHold);
  const RenderedTick tick = renderer.render(scene.view(), {}, 0);
  CHECK(tick.truncated);
  CHECK(tick.force.contacts == static_cast<int>(TouchedSpheres::kCapacity));
  CHECK(tick.force.force_N.allFinite());
}

TEST_CASE("A sphere that is no number is never touched", "[tool_force]") {
  collision::VoxelGrid grid(0, 1);
  grid.records()[0] = collision::static_sphere({0.0F, 0.0F, 0.0F}, 0.01F);
  grid.enter(collision::history_bounds(grid.records()), 1.0F);
  const std::array<PlacedToolSphere, 1> tool{{{{0.001, 0.0, 0.0}, 0.005}}};
  const auto touched_with = [&](float x_m, float speed_m_s) {
    const proto::SphereState snapshot{{x_m, 0.0F, 0.0F}, {speed_m_s, 0.0F, 0.0F}};
    grid.records()[0].newest = snapshot;  // words changed after the sphere was entered
    TouchedSpheres touched;
    gather_touched(grid.view(), {}, tool, touched);
    return touched.count;
  };
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  CHECK(touched_with(0.0F, 0.0F) == 1);
  CHECK(touched_with(kNaN, 0.0F) == 0);
  CHECK(touched_with(0.0F, kNaN) == 0);
}

}  // namespace
}  // namespace stillgrid::rendering::tool_force_test
