#include <catch2/catch.hpp>

#include "tests/haptic_server/devices/allocation_counter.hpp"
#include "tests/shared/dynamics/engine_scenes.hpp"

namespace stillgrid::dynamics::allocation_test {
namespace {

TEST_CASE("Ticks of a settled pile and its saved blocks allocate nothing", "[dynamics]") {
  Engine engine = falling_pile(100).engine();
  std::vector<std::byte> block;
  const auto throw_up = [&](double speed_m_s) {
    SceneState thrown = engine.state();
    for (Vector4& velocity : thrown.rigid_velocity_m_s) velocity.z += speed_m_s;
    engine.set_state(std::move(thrown));
  };
  const auto run = [&] {
    for (int k = 0; k < 500; ++k) engine.step();
    engine.save(block);
  };
  run();
  throw_up(0.5);
  run();
  throw_up(0.2);
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
