#include "shared/tools/scene_viewer/tick_history.hpp"

#include <catch2/catch.hpp>

namespace stillgrid::scene_viewer::tick_history_test {
namespace {

TickSample sample_of(std::uint64_t tick, double time_s) {
  TickSample sample;
  sample.tick = tick;
  sample.time_s = time_s;
  return sample;
}

TEST_CASE("Ticks are given from a number on, at most so many", "[tick_history]") {
  TickHistory history;
  for (const std::uint64_t tick : {3U, 4U, 7U, 8U, 9U})
    history.add(sample_of(tick, 1e-3 * static_cast<double>(tick)));
  const auto found = history.from(5, 2);
  REQUIRE(found.size() == 2);
  CHECK(found[0].tick == 7);
  CHECK(found[1].tick == 8);
  CHECK(history.from(10, 5).empty());
  CHECK(history.from(0, 100).size() == 5);
}

TEST_CASE("The summary is of the last second, and its numbers tell what was not seen",
          "[tick_history]") {
  TickHistory history;
  for (std::uint64_t tick = 1; tick <= 3000; ++tick) {
    if (tick % 10 == 0) continue;
    TickSample sample = sample_of(tick, 1e-3 * static_cast<double>(tick));
    sample.work_us = static_cast<double>(tick <= 2000 ? 1000 : tick - 2000);
    sample.wake_us = 5.0;
    sample.missed = tick / 1000;
    history.add(sample);
  }
  const TickSummary summary = history.summary();
  CHECK(summary.expected == 999);
  CHECK(summary.seen == 900);
  CHECK(summary.per_s == Approx(1000.0));
  CHECK(summary.missed == 2);
  CHECK(summary.work_us.p50 == Approx(500.0).margin(2.0));
  CHECK(summary.work_us.p99 == Approx(990.0).margin(2.0));
  CHECK(summary.work_us.p999 == 999.0);
  CHECK(summary.wake_us.p50 == 5.0);
}

TEST_CASE("Of a long run the last minute is held, and little more", "[tick_history]") {
  TickHistory history;
  for (std::uint64_t tick = 1; tick <= 20'000; ++tick)
    history.add(sample_of(tick, 0.01 * static_cast<double>(tick)));
  const auto held = history.from(0, 1'000'000);
  CHECK(held.back().tick == 20'000);
  CHECK(held.front().time_s <= 200.0 - 60.0);
  CHECK(held.front().time_s >= 200.0 - 121.0);
}

TEST_CASE("Whatever the rate there are bounds to what is held", "[tick_history]") {
  TickHistory history;
  for (std::uint64_t tick = 1; tick <= 600'000; ++tick)
    history.add(sample_of(tick, 1e-6 * static_cast<double>(tick)));
  CHECK(history.from(0, 1'000'000).size() < 240'001);
}

TEST_CASE("Without a tick there is nothing to tell", "[tick_history]") {
  const TickSummary summary = TickHistory().summary();
  CHECK(summary.seen == 0);
  CHECK(summary.expected == 0);
  CHECK(summary.work_us.p999 == 0.0);
}

}  // namespace
}  // namespace stillgrid::scene_viewer::tick_history_test
