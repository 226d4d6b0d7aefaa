#include "shared/publication/lockstep.hpp"

#include <catch2/catch.hpp>
#include <thread>

#include "shared/double_buffer/double_buffer.hpp"

namespace stillgrid::publication::lockstep_test {
namespace {

const std::atomic<bool> kGoOn = false;

TEST_CASE("A promise already kept costs no wait", "[lockstep]") {
  const auto still_there = [] { return false; };
  const std::atomic<bool> stop = true;

  CHECK(wait_for_promise([] { return std::uint64_t{5}; }, 5, still_there, stop) ==
        WaitResult::kReached);
  CHECK(wait_for_promise([] { return UINT64_MAX; }, 5, still_there, stop) == WaitResult::kReached);
}

TEST_CASE("A wait ends when the peer's promise reaches the time", "[lockstep]") {
  std::uint64_t promise = 0;
  std::thread peer([&] {
    for (std::uint64_t time_ns = 1; time_ns <= 1000; ++time_ns)
      double_buffer::HardwareAtomics::store(promise, time_ns, std::memory_order_release);
  });

  const WaitResult result = wait_for_promise(
      [&] { return double_buffer::HardwareAtomics::load(promise, std::memory_order_acquire); },
      1000, [] { return true; }, kGoOn);
  peer.join();

  CHECK(result == WaitResult::kReached);
}

TEST_CASE("A wait ends when the user stops the program", "[lockstep]") {
  std::atomic<bool> stop = false;
  int looks = 0;
  const auto word = [&] {
    if (++looks == 1000) stop = true;
    return std::uint64_t{0};
  };

  CHECK(wait_for_promise(
            word, 1, [] { return true; }, stop) == WaitResult::kStopped);
}

TEST_CASE("A wait ends when the peer is gone", "[lockstep]") {
  int asked = 0;
  const auto still_there = [&] { return ++asked < 3; };

  CHECK(wait_for_promise([] { return std::uint64_t{0}; }, 1, still_there, kGoOn) ==
        WaitResult::kPeerGone);
  CHECK(asked == 3);
}

TEST_CASE("A peer that keeps its promise and then ends has kept it", "[lockstep]") {
  std::uint64_t promise = 0;
  const auto ends_after_keeping_it = [&] {
    promise = 1;
    return false;
  };

  CHECK(wait_for_promise([&] { return promise; }, 1, ends_after_keeping_it, kGoOn) ==
        WaitResult::kReached);
}

}  // namespace
}  // namespace stillgrid::publication::lockstep_test
