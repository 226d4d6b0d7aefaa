#include "haptic_server/safety/tick_watchdog.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

namespace stillgrid::safety::tick_watchdog_test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kPeriod_ns = 1'000'000;

TEST_CASE("A loop that no longer ticks is stopped once, then given up", "[tick_watchdog]") {
  std::atomic<int> stopped = 0, given_up = 0;
  const auto began = std::chrono::steady_clock::now();
  TickWatchdog watchdog(
      kPeriod_ns, [&] { ++stopped; }, [&] { ++given_up; });
  watchdog.watch_ticks();
  while (given_up == 0) std::this_thread::sleep_for(1ms);
  CHECK(std::chrono::steady_clock::now() - began >= 1100ms);
  CHECK(stopped == 1);
  CHECK(watchdog.stops() == 1);
}

TEST_CASE("A loop that comes back is watched anew", "[tick_watchdog]") {
  std::atomic<int> stopped = 0, given_up = 0;
  TickWatchdog watchdog(
      kPeriod_ns, [&] { ++stopped; }, [&] { ++given_up; });
  watchdog.watch_ticks();
  for (int times = 1; times <= 2; ++times) {
    while (stopped < times) std::this_thread::sleep_for(1ms);
    watchdog.tick();
  }
  CHECK(given_up == 0);
  CHECK(stopped == 2);
}

TEST_CASE("A slow loop's watchdog waits for three of its periods", "[tick_watchdog]") {
  std::atomic<int> stopped = 0;
  const auto began = std::chrono::steady_clock::now();
  TickWatchdog watchdog(
      100'000'000, [&] { ++stopped; }, [] {});
  watchdog.watch_ticks();
  while (stopped == 0) std::this_thread::sleep_for(1ms);
  CHECK(std::chrono::steady_clock::now() - began >= 300ms);
}

TEST_CASE("A loop that ends does not wait for a poll of its watchdog", "[tick_watchdog]") {
  int late = 0;
  for (int times = 0; times < 200; ++times) {
    const auto began = std::chrono::steady_clock::now();
    TickWatchdog(
        kPeriod_ns, [] {}, [] {});
    late += std::chrono::steady_clock::now() - began >= 10ms ? 1 : 0;  // as a poll takes
  }
  CHECK(late < 100);
}

TEST_CASE("A driver whose stop does not return is given up all the same", "[tick_watchdog]") {
  std::atomic<bool> given_up = false, may_return = false;
  TickWatchdog watchdog(
      kPeriod_ns,
      [&] {
        while (!may_return) std::this_thread::sleep_for(1ms);
      },
      [&] { given_up = true; });
  watchdog.watch_ticks();
  while (!given_up) std::this_thread::sleep_for(1ms);
  CHECK(watchdog.is_stopping());  // a loop that comes back now may tell it nothing
  CHECK(watchdog.stops() == 0);
  may_return = true;
}

TEST_CASE("A call that is to release the device is helped by a stop after a second, not given up",
          "[tick_watchdog]") {
  std::atomic<int> stopped = 0, given_up = 0;
  const auto began = std::chrono::steady_clock::now();
  TickWatchdog watchdog(
      kPeriod_ns, [&] { ++stopped; }, [&] { ++given_up; });
  watchdog.watch_release();
  while (stopped == 0) std::this_thread::sleep_for(1ms);
  CHECK(std::chrono::steady_clock::now() - began >= 1s);
  std::this_thread::sleep_for(400ms);
  CHECK(stopped == 1);
  CHECK(given_up == 0);
}

TEST_CASE("A watchdog beats for as long as it lives", "[tick_watchdog]") {
  std::atomic<int> beats = 0;
  TickWatchdog watchdog(
      kPeriod_ns, [] {}, [] {}, [&] { ++beats; });
  while (beats < 5) std::this_thread::sleep_for(1ms);
  SUCCEED();
}

TEST_CASE("A call that may block, and a loop at rest, are neither stopped nor given up so soon",
          "[tick_watchdog]") {
  std::atomic<int> stopped = 0, given_up = 0;
  TickWatchdog watchdog(
      kPeriod_ns, [&] { ++stopped; }, [&] { ++given_up; });
  watchdog.watch_call();
  std::this_thread::sleep_for(1500ms);
  watchdog.rest();
  std::this_thread::sleep_for(300ms);
  CHECK(stopped == 0);
  CHECK(given_up == 0);
}

}  // namespace
}  // namespace stillgrid::safety::tick_watchdog_test
