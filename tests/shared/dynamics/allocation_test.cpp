#include <catch2/catch.hpp>

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

}  // namespace
}  // namespace stillgrid::dynamics::allocation_test
