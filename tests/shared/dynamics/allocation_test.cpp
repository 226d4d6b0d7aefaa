#include <catch2/catch.hpp>

#include "tests/haptic_server/devices/allocation_counter.hpp"
#include "tests/shared/dynamics/engine_scenes.hpp"

namespace stillgrid::dynamics::allocation_test {
namespace {

TEST_CASE("Ticks of a settled pile and its saved blocks allocate nothing", "[dynamics]") {
  Engine engine = falling_pile(100).engine();
  std::vector<std::byte> block;
  const auto run = [&] {
    for (int k = 0; k < 500; ++k) engine.step();
    engine.save(block);
  };
  run();
  run();
  const auto before = devices::allocation_count();
  if (!before) return;  // only the address sanitizer counts
  const std::size_t listings = engine.listing().listings();
  run();
  CHECK(engine.listing().listings() > listings);
  CHECK(devices::allocation_count() == before);
}

}  // namespace
}  // namespace stillgrid::dynamics::allocation_test
