#include <catch2/catch.hpp>
#include <vector>

#include "tests/shared/dynamics/implicit_scenes.hpp"

namespace stillgrid::dynamics::sleep_test {
namespace {

/// Lets a free rigid body sleep.
void may_sleep(EngineScene& scene, int rigid) {
  scene.description.bodies.push_back(
      {.rigid = rigid, .rest_speed_m_s = 1.5e-4, .bounding_radius_m = 0.03});
}
/// Two stacks of blocks on a floor, a thread that hangs, and a tool.
EngineScene stacks() {
  EngineScene scene;
  scene.with_gravity();
  scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
  for (int k = 0; k < 6; ++k)
    may_sleep(scene, scene.add_block(0.05, {0.03, 0.03, 0.02},
                                     {0.1 * (k / 3), 0.0, 0.0099 + 0.0199 * (k % 3)}));
  const int first = scene.add_node(0.01, {0.3, 0.0, 0.2}, true);
  int before = first;
  for (int k = 1; k < 4; ++k) {
    const int node = scene.add_node(0.01, {0.3, 0.0, 0.2 - 0.02 * k});
    scene.add_spring(before, node, 200.0, 1.0);
    before = node;
  }
  scene.description.bodies.push_back(
      {.first_node = first, .node_count = 4, .rest_speed_m_s = 1.5e-4});
  const int tool = scene.add_rigid(0.0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), true);
  scene.add_sphere(tool, 0.005);
  scene.description.spheres.back().is_tool = true;
  return scene;
}
std::vector<DrivenPose> tool_at(const Eigen::Vector3d& position_m) {
  return {DrivenPose{.position_m = position_m}};
}
const std::vector<DrivenPose> kAway{DrivenPose{.is_here = false}};

void lull(Engine& engine) {
  for (int tick = 0; tick < 20000 && !engine.sleep().all_sleep(); ++tick) engine.step(kAway);
  REQUIRE(engine.sleep().all_sleep());
}
/// A block without the number of the tick.
std::vector<std::byte> timeless(const Engine& engine) {
  std::vector<std::byte> block;
  engine.save(block);
  std::fill(block.begin() + 16, block.begin() + 24, std::byte{});
  return block;
}

TEST_CASE("Scenes at rest sleep, and change by no bit", "[sleep]") {
  Engine engine = stacks().engine(each_method());
  double lost_J = 0.0;
  for (int tick = 0; tick < 20000 && !engine.sleep().all_sleep(); ++tick) {
    engine.step(kAway);
    lost_J += engine.sleep().loss_J();
  }
  REQUIRE(engine.sleep().all_sleep());
  CHECK(lost_J > 0.0);
  CHECK(lost_J < 0.5 * 0.34 * 1.5e-4 * 1.5e-4);
  const double held_J = engine.contact_energy_J();
  CHECK(held_J > 1e-5);
  engine.step(kAway);
  const auto before = timeless(engine);
  const std::size_t listings = engine.listing().listings();
  for (int tick = 0; tick < 500; ++tick) engine.step(kAway);
  CHECK((timeless(engine) == before));
  CHECK(engine.contact_energy_J() == held_J);
  // A tool that comes as near as 1 mm.
  for (int tick = 0; tick < 500; ++tick) engine.step(tool_at({-0.1 + 4e-4 * tick, 0.0, 0.066}));
  CHECK(engine.sleep().all_sleep());
  CHECK(engine.listing().listings() == listings);
}

TEST_CASE("A tool wakes the island that it would touch, in the same tick, and no other",
          "[sleep]") {
  Engine engine = stacks().engine(each_method());
  lull(engine);
  int tick = 0;
  for (; tick < 200 && engine.sleep().all_sleep(); ++tick)
    engine.step(tool_at({0.01, 0.01, 0.09 - 2e-4 * tick}));
  CHECK(engine.sleep().sleeping() == 4);
  CHECK(engine.reactions()[0].impulse_N_s.z() > 0.0);
  // It keeps the island awake; without it all sleep again.
  for (int more = 0; more < 2000; ++more) engine.step(tool_at({0.01, 0.01, 0.09 - 2e-4 * tick}));
  CHECK(engine.sleep().sleeping() == 4);
  lull(engine);
}

TEST_CASE("A block that slept on a slope wakes held as it was", "[sleep]") {
  EngineScene scene;
  scene.description.gravity_m_s2 = 9.81 * Eigen::Vector3d(0.17, 0.0, -0.985);
  scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
  const int block = scene.add_block(0.05, {0.03, 0.03, 0.02}, {0.0, 0.0, 0.0099});
  may_sleep(scene, block);
  const int tool = scene.add_rigid(0.0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), true);
  scene.add_sphere(tool, 0.005);
  scene.description.spheres.back().is_tool = true;
  Engine engine = scene.engine(each_method());
  lull(engine);
  const Eigen::Vector3d before = engine.state().rigid_position_m[0].vector();
  // A tool that hardly touches one of the upper spheres.
  const Eigen::Vector3d above =
      sphere_position_m(engine.description().spheres[7], engine.state()).vector() +
      Eigen::Vector3d(0.0, 0.0, 0.01 - 1e-9);
  engine.step(tool_at(above));
  REQUIRE(engine.sleep().sleeping() == 0);
  for (int tick = 0; tick < 300; ++tick) {
    engine.step(kAway);
    CHECK((engine.state().rigid_position_m[0].vector() - before).norm() < 1e-7);
  }
}

TEST_CASE("Runs through saved blocks are equal to the bit, sleeping, half awake and waking",
          "[sleep]") {
  const auto pose = [](int tick) {
    return tick < 4000 ? kAway : tool_at({0.01, 0.01, 0.09 - 1e-5 * (tick - 4000)});
  };
  const EngineMethod method = each_method();
  Engine whole = stacks().engine(method);
  std::vector<std::byte> block, other;
  int halves = 0;
  for (int tick = 0; tick < 8000; ++tick) {
    whole.step(pose(tick));
    if (tick % 400 != 399) continue;
    if (whole.sleep().sleeping() > 0) ++halves;
    whole.save(block);
    Engine loaded = stacks().engine(method);
    loaded.load(block);
    for (int more = 1; more <= 30; ++more) loaded.step(pose(tick + more));
    Engine again = stacks().engine(method);
    again.load(block);
    again.save(other);
    CHECK((other == block));
    for (int more = 1; more <= 30; ++more) {
      whole.step(pose(tick + more));
    }
    tick += 30;
    whole.save(block);
    loaded.save(other);
    CHECK((other == block));
  }
  CHECK(halves > 5);
  CHECK(whole.sleep().sleeping() < 7);
}

TEST_CASE("What a pendulum does at its turning point is no rest", "[sleep]") {
  EngineScene scene;
  scene.with_gravity();
  const int ends[2] = {scene.add_node(0.1, {0.0, 0.0, 0.0}, true),
                       scene.add_node(0.1, {0.01, 0.0, -1.0})};
  scene.add_spring(ends[0], ends[1], 1e4);
  scene.description.bodies.push_back({.node_count = 2, .rest_speed_m_s = 1.5e-4});
  Engine engine = scene.engine(each_method());
  for (int tick = 0; tick < 4000; ++tick) {
    engine.step();
    CHECK(engine.sleep().sleeping() == 0);
  }
}

}  // namespace
}  // namespace stillgrid::dynamics::sleep_test
