#include <catch2/catch.hpp>
#include <random>

#include "tests/haptic_server/safety/safety_input.hpp"

namespace stillgrid::safety::fade_test {
namespace {

TEST_CASE("The force ramps in from zero over 100 ms", "[safety_chain]") {
  SafetyChain chain({.max_force_N = 3.3});
  for (int ms = 1; ms <= 100; ++ms) {
    const Commanded commanded = tick(chain, push(1.0));
    CHECK(commanded.x_N() == Approx(0.01 * ms));
    if (ms < 100) CHECK(commanded.flags == kFlagRamped);
  }
  CHECK(tick(chain, push(1.0)).flags == 0);
}

TEST_CASE("A stale snapshot fades to zero between 1.5 periods and 100 ms later", "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 3.3});
  (void)tick(chain, push(1.0));
  SafetyInput ageing = push(1.0);
  double previous_N = 1.0;
  for (int ms = 1; ms <= 160; ++ms) {
    ageing.snapshot.snapshot_age_s = ms * 1e-3;
    const Commanded commanded = tick(chain, ageing);
    CHECK(previous_N - commanded.x_N() < 0.0101);
    if (ms <= 49) CHECK(commanded.x_N() == 1.0);
    if (ms >= 150) CHECK(commanded.x_N() == 0.0);
    if (ms >= 50) CHECK(commanded.flags == kFlagFaded);
    previous_N = commanded.x_N();
  }
}

TEST_CASE("A dead simulation fades at once, whatever the snapshot's age", "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 3.3});
  (void)tick(chain, push(1.0));
  for (int ms = 1; ms <= 99; ++ms)
    CHECK(tick(chain, dead(push(1.0))).x_N() == Approx(1.0 - 0.01 * ms));
  (void)tick(chain, dead(push(1.0)));
  CHECK(tick(chain, dead(push(1.0))).x_N() == 0.0);
  CHECK(chain.is_silent());
}

TEST_CASE("A force far above the limit fades as evenly as one below it", "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 2.0});
  (void)tick(chain, push(1000.0));
  for (int ms = 1; ms <= 99; ++ms)
    CHECK(tick(chain, dead(push(1000.0))).x_N() == Approx(2.0 - 0.02 * ms));
}

TEST_CASE("The fade of a dead simulation ends in 100 ms also where ticks are missed",
          "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 2.0, .max_slew_N_per_ms = 0.02});
  for (int i = 0; i < 200; ++i) (void)tick(chain, push(2.0));
  std::mt19937 random(7);
  std::uniform_int_distribution<int> missed(0, 20);
  double since_s = 0.0, force_N = 2.0;
  while (force_N > 0.0) {
    SafetyInput input = dead(push(2.0));
    input.elapsed_s = 1e-3 * (1 + missed(random));
    since_s += input.elapsed_s;
    force_N = tick(chain, input).x_N();
    CHECK((force_N <= 0.0) == (since_s > 0.1 - 1e-9));
  }
}

TEST_CASE("A device that is not believed fades its force, and ramps in again", "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 3.3});
  SafetyInput lost = push(1.0);
  lost.device_believed = false;
  const Commanded first = tick(chain, lost);
  CHECK(first.x_N() == Approx(0.99));
  CHECK(first.flags == (kFlagBadDevice | kFlagRamped));
  CHECK(after(chain, lost, 100).x_N() == 0.0);
  CHECK(tick(chain, push(1.0)).x_N() == Approx(0.01));
  CHECK(after(chain, push(1.0), 99).x_N() == Approx(1.0));
}

TEST_CASE("A stall cuts to zero at once, beyond any slew limit, and a ramp follows",
          "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 3.3, .max_slew_N_per_ms = 0.05});
  REQUIRE(after(chain, push(2.0), 100).x_N() == 2.0);
  SafetyInput late = push(2.0);
  late.elapsed_s = 0.049;
  CHECK(tick(chain, late).x_N() == 2.0);
  late.elapsed_s = 0.05;
  const Commanded commanded = tick(chain, late);
  CHECK(commanded.x_N() == 0.0);
  CHECK((commanded.flags & kFlagStalled) != 0);
  CHECK(tick(chain, push(2.0)).x_N() == Approx(0.02));
  chain.cut();
  CHECK(tick(chain, push(2.0)).x_N() == Approx(0.02));
}

TEST_CASE("What the control of energy adds fades with a dead simulation", "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 3.3, .passivity_mass_kg = 0.1});
  SafetyInput input = push(1.0);
  (void)tick(chain, input);
  input.motion.moved_m = {0.01, 0.0, 0.0};  // 10 mJ are given
  const Commanded damped = tick(chain, input);
  REQUIRE((damped.flags & kFlagPassivity) != 0);
  REQUIRE(damped.x_N() < 1.0);
  CHECK(after(chain, dead(input), 101).wrench.force_N.isZero(0.0));
}

TEST_CASE("A snapshot is waited for no longer than a second, whatever period is declared",
          "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 3.3});
  SafetyInput slow = push(1.0);
  slow.snapshot.period_s = 100.0;
  slow.snapshot.snapshot_age_s = 0.99;
  CHECK(tick(chain, slow).flags == 0);
  slow.snapshot.snapshot_age_s = 1.01;
  CHECK(after(chain, slow, 101).x_N() == 0.0);
}

}  // namespace
}  // namespace stillgrid::safety::fade_test
