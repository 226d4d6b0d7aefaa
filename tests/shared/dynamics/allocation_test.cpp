#include <catch2/catch.hpp>

#include "tests/haptic_server/devices/allocation_counter.hpp"
#include "tests/shared/dynamics/engine_scenes.hpp"

namespace stillgrid::dynamics::allocation_test {
namespace {

TEST_CASE("Ticks of a thrown pile and its saved blocks allocate nothing the second time",
          "[dynamics]") {
  Engine engine = falling_pile(100).engine();
  for (int k = 0; k < 500; ++k) engine.step();
  SceneState thrown = engine.state();
  for (Vector4& velocity : thrown.rigid_velocity_m_s) velocity.z += 0.5;
  engine.set_state(std::move(thrown));
  std::vector<std::byte> start, block;
  engine.save(start);
  const auto run = [&] {
    for (int k = 0; k < 500; ++k) engine.step();
    engine.save(block);
  };
  run();
  engine.load(start);
  const auto before = devices::allocation_count();
  if (!before) return;  // only the address sanitizer counts
  const std::size_t listings = engine.listing().listings();
  run();
  const auto after = devices::allocation_count();  // a check that fails allocates
  CHECK(after == before);
  CHECK(engine.listing().listings() > listings);
}

}  // namespace
}  // namespace stillgrid::dynamics::allocation_test
