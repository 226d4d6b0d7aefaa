#include "shared/realtime/periodic_timer.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

namespace stillgrid::realtime::periodic_timer_test {
namespace {

constexpr std::uint64_t kPeriod_ns = 500'000;

TEST_CASE("The clock of the loops never goes back", "[periodic_timer]") {
  std::uint64_t last_ns = monotonic_ns();
  int backwards = 0;
  for (int i = 0; i < 10000; ++i) {
    const std::uint64_t now_ns = monotonic_ns();
    if (now_ns < last_ns) ++backwards;
    last_ns = now_ns;
  }
  CHECK(backwards == 0);
}

TEST_CASE("Deadlines are whole multiples of the period however late the loop wakes",
          "[periodic_timer]") {
  const std::uint64_t before_ns = monotonic_ns();
  PeriodicTimer timer(kPeriod_ns);
  const std::uint64_t after_ns = monotonic_ns();

  const PeriodicTimer::Wake first = timer.wait();
  CHECK(first.deadline_ns % kPeriod_ns == 0);
  CHECK(first.deadline_ns > before_ns);
  CHECK(first.deadline_ns <= after_ns + kPeriod_ns);

  std::uint64_t periods = first.skipped, skipped = first.skipped;
  int off_grid = 0, early = 0;
  for (int i = 0; i < 100; ++i) {
    const PeriodicTimer::Wake wake = timer.wait();
    ++periods;
    if (wake.deadline_ns != first.deadline_ns + periods * kPeriod_ns) ++off_grid;
    if (wake.now_ns < wake.deadline_ns) ++early;
    periods += wake.skipped;
    skipped += wake.skipped;
  }
  CHECK(off_grid == 0);
  CHECK(early == 0);
  CHECK(periods == 100 + skipped);
}

TEST_CASE("A loop with a phase wakes so long after the others", "[periodic_timer]") {
  constexpr std::uint64_t kPhase_ns = kPeriod_ns / 4;
  PeriodicTimer timer(kPeriod_ns, kPhase_ns);
  for (int i = 0; i < 3; ++i) CHECK(timer.wait().deadline_ns % kPeriod_ns == kPhase_ns);
}

TEST_CASE("After a stall missed deadlines are counted and never made up for", "[periodic_timer]") {
  PeriodicTimer timer(kPeriod_ns);
  const PeriodicTimer::Wake before = timer.wait();
  std::this_thread::sleep_for(std::chrono::nanoseconds(20 * kPeriod_ns));

  const PeriodicTimer::Wake late = timer.wait();
  const PeriodicTimer::Wake next = timer.wait();

  CHECK(late.deadline_ns == before.deadline_ns + (before.skipped + 1) * kPeriod_ns);
  CHECK(late.skipped >= 18);
  CHECK(next.deadline_ns == late.deadline_ns + (late.skipped + 1) * kPeriod_ns);
  CHECK(next.deadline_ns > late.now_ns);  // a deadline still to come: no burst
  CHECK(next.now_ns >= next.deadline_ns);
}

}  // namespace
}  // namespace stillgrid::realtime::periodic_timer_test
