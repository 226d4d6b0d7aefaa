#include "shared/realtime/spsc_ring.hpp"

#include <catch2/catch.hpp>
#include <cstdint>
#include <thread>

namespace stillgrid::realtime::spsc_ring_test {
namespace {

TEST_CASE("An empty ring gives nothing and a full one takes nothing", "[spsc_ring]") {
  SpscRing<int> ring(3);  // rounded up to four
  int item = -1;
  CHECK_FALSE(ring.pop(item));
  CHECK(item == -1);

  for (int i = 0; i < 4; ++i) CHECK(ring.push(i));
  CHECK_FALSE(ring.push(4));

  for (int i = 0; i < 4; ++i) {
    REQUIRE(ring.pop(item));
    CHECK(item == i);
  }
  CHECK_FALSE(ring.pop(item));
}

TEST_CASE("Items come out in order however often the ring goes round", "[spsc_ring]") {
  SpscRing<int> ring(4);
  int item = 0;
  for (int i = 0; i < 1000; ++i) {
    REQUIRE(ring.push(2 * i));
    REQUIRE(ring.push(2 * i + 1));
    REQUIRE(ring.pop(item));
    CHECK(item == 2 * i);
    REQUIRE(ring.pop(item));
    CHECK(item == 2 * i + 1);
  }
}

/// Large enough to be seen half written.
struct Item {
  std::uint64_t number = 0;
  std::uint64_t copies[7] = {};
};

TEST_CASE("Between two threads nothing is lost, doubled, mixed or out of order", "[spsc_ring]") {
  constexpr std::uint64_t kItems = 200000;
  SpscRing<Item> ring(64);
  std::thread producer([&] {
    for (std::uint64_t number = 1; number <= kItems; ++number) {
      Item item{number, {}};
      for (std::uint64_t& copy : item.copies) copy = number;
      while (!ring.push(item)) std::this_thread::yield();
    }
  });

  std::uint64_t out_of_order = 0, mixed = 0;
  for (std::uint64_t expected = 1; expected <= kItems; ++expected) {
    Item item;
    while (!ring.pop(item)) std::this_thread::yield();
    if (item.number != expected) ++out_of_order;
    for (const std::uint64_t copy : item.copies)
      if (copy != item.number) ++mixed;
  }
  producer.join();

  CHECK(out_of_order == 0);
  CHECK(mixed == 0);
  Item item;
  CHECK_FALSE(ring.pop(item));
}

}  // namespace
}  // namespace stillgrid::realtime::spsc_ring_test
