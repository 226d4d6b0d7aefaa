#include <catch2/catch.hpp>
#include <optional>

#include "shared/dynamics/scene_ticks.hpp"
#include "tests/haptic_server/devices/allocation_counter.hpp"
#include "tests/shared/dynamics/drawn_scene.hpp"
#include "tests/shared/dynamics/implicit_scenes.hpp"

namespace stillgrid::dynamics::allocation_test {
namespace {

/// Runs from a state, goes back, and checks that the same run allocates nothing then.
template <class Run>
void check_second(Engine& engine, const Run& run) {
  std::vector<std::byte> start, block;
  engine.save(start);
  const auto run_and_save = [&] {
    run();
    engine.save(block);
  };
  run_and_save();
  engine.load(start);
  const auto before = devices::allocation_count();
  if (!before) return;  // only the address sanitizer counts
  const std::size_t listings = engine.listing().listings();
  run_and_save();
  const auto after = devices::allocation_count();  // a check that fails allocates
  CHECK(after == before);
  CHECK(engine.listing().listings() > listings);
}

TEST_CASE("Ticks of a thrown pile and its saved blocks allocate nothing the second time",
          "[dynamics]") {
  Engine engine = falling_pile(100).engine();
  for (int k = 0; k < 500; ++k) engine.step();
  SceneState thrown = engine.state();
  for (Vector4& velocity : thrown.rigid_velocity_m_s) velocity.z += 0.5;
  engine.set_state(std::move(thrown));
  check_second(engine, [&] {
    for (int k = 0; k < 500; ++k) engine.step();
  });
}

TEST_CASE("Ticks of balls, blocks, threads and a tool allocate nothing the second time",
          "[dynamics]") {
  const DrawnScene drawn(GENERATE(3U, 4U));
  Engine engine = drawn.scene.engine(each_method());
  check_second(engine, [&] {
    for (int k = 0; k < 100; ++k) {
      const DrivenPose pose = drawn.tool(engine.state().tick);
      engine.step(std::span(&pose, 1));
    }
  });
}

/// Pre: the last rigid body is the tool.
SceneModel with_a_hand(const EngineScene& scene) {
  SceneModel model;
  model.description = scene.description;
  model.start = scene.state;
  model.start.is_here.assign(model.description.rigid_bodies.size(), 1);
  model.start.is_here.back() = 0;
  model.hands = 1;
  for (std::size_t r = 0; r + 1 < model.description.rigid_bodies.size(); ++r)
    model.description.bodies.push_back(
        {.rigid = static_cast<std::int32_t>(r), .rest_speed_m_s = 1e-2});
  return model;
}

/// A sheet of balls at rest, high above a floor, and a tool.
EngineScene sheet_above_floor() {
  EngineScene scene;
  scene.add_plane(Eigen::Vector3d::UnitZ(), -0.1);
  for (int i = 0; i < 64; ++i)
    scene.add_ball(0.004, {0.0085 * (i % 8 - 4), 0.0085 * (i / 8 - 4), 0});
  scene.add_sphere(scene.add_rigid(0.0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), true),
                   0.008);
  scene.description.spheres.back().is_tool = true;
  return scene;
}

constexpr std::uint64_t kTicks = 450;  // the tool comes again each 400

/// The copy takes a state of the simulation each 16 ticks. pose(tick) is the tool's.
template <class PoseAt>
void check_copy(const SceneModel& model, const PoseAt& pose_at) {
  SceneTicks followed{SceneModel(model)}, copy{SceneModel(model)};
  copy.warm_up();
  std::vector<std::byte> block;
  std::vector<std::optional<ToolPose>> tools(1);
  std::uint64_t allocated = 0;
  for (std::uint64_t tick = 0; tick < kTicks; ++tick) {
    const DrivenPose pose = pose_at(tick);
    tools[0].reset();
    if (pose.is_here) tools[0] = {pose.position_m, pose.orientation, pose.velocity_m_s};
    followed.step({.tools = tools});
    if (tick % 16 == 0) followed.save(block);
    const auto before = devices::allocation_count();
    if (!before) return;  // only the address sanitizer counts
    tick % 16 == 0 ? copy.load(block) : copy.step({.tools = tools});
    allocated += *devices::allocation_count() - *before;
  }
  CHECK(allocated == 0);
}

TEST_CASE("A warm copy allocates nothing while it follows another simulation", "[dynamics]") {
  const DrawnScene drawn(GENERATE(range(1U, 4U)));
  check_copy(with_a_hand(drawn.scene), [&](std::uint64_t tick) { return drawn.tool(tick % 400); });
}

TEST_CASE("A warm copy allocates nothing where a tool meets more than the copy was warmed up with",
          "[dynamics]") {
  check_copy(with_a_hand(sheet_above_floor()), [](std::uint64_t tick) {
    DrivenPose pose;
    pose.position_m.z() = 0.03 - 1e-4 * static_cast<double>(tick % 400);
    pose.velocity_m_s.z() = -0.1;
    return pose;
  });
}

}  // namespace
}  // namespace stillgrid::dynamics::allocation_test
