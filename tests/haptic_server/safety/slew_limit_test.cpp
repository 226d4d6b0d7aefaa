#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/haptic_server/safety/safety_input.hpp"

namespace stillgrid::safety::slew_limit_test {
namespace {

TEST_CASE("The norm falls at once, and grows and turns by the slew limit", "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 3.3, .max_slew_N_per_ms = 0.5});
  CHECK(after(chain, push(3.0), 6).x_N() == Approx(3.0));
  const Commanded fallen = tick(chain, push(0.2));
  CHECK(fallen.x_N() == 0.2);
  CHECK(fallen.flags == 0);
  const Commanded grown = tick(chain, push(3.0));
  CHECK(grown.x_N() == Approx(0.7));
  CHECK(grown.flags == kFlagSlewed);

  REQUIRE(after(chain, push(3.0), 6).x_N() == Approx(3.0));
  const Eigen::Vector3d turned_N = tick(chain, push(0.0, 3.0)).wrench.force_N;
  CHECK(turned_N.x() == 0.0);  // no force but along the rendered one
  CHECK(turned_N.y() == Approx(0.5 / std::sqrt(2.0)));
  const double small_rad = 0.05;
  REQUIRE(after(chain, push(3.0), 12).x_N() == Approx(3.0));
  const Commanded nudged = tick(chain, push(3.0 * std::cos(small_rad), 3.0 * std::sin(small_rad)));
  CHECK(nudged.flags == 0);
}

TEST_CASE("Growth is granted for the time since the last write, and for a period at most",
          "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 3.3, .max_slew_N_per_ms = 0.3});
  SafetyInput input = push(3.0);
  input.elapsed_s = 0.02;  // a tick that came late
  input.since_command_s = 0.0205;
  CHECK(tick(chain, input).x_N() == Approx(0.3));
  input.since_command_s = 0.2e-3;  // and was told late: the next is told soon after
  CHECK(tick(chain, input).x_N() == Approx(0.36));
}

TEST_CASE("A press that a slow force did not stop is not paid back", "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 10.0, .max_slew_N_per_ms = 0.1});
  SafetyInput input = push(0.0);
  input.stiffness_N_per_m(0, 0) = 1000.0;
  input.velocity_m_s = {-1.0, 0.0, 0.0};
  double given_J = 0.0, commanded_N = 0.0;
  std::uint32_t flags = 0;
  for (int step = 0; step < 10; ++step) {  // 5 mm in, 5 mm out
    input.motion.moved_m.x() = step < 5 ? -1e-3 : 1e-3;
    given_J += commanded_N * input.motion.moved_m.x();
    input.rendered.force_N.x() = step < 5 ? 1.0 + step : 9.0 - step;
    const Commanded commanded = tick(chain, input);
    commanded_N = commanded.x_N();
    flags |= commanded.flags;
  }
  CHECK(given_J <= 0.5 * 1000.0 * 5 * 1e-6);  // what a hold leaks
  CHECK((flags & kFlagEnergy) != 0);
}

TEST_CASE("What was withheld comes back within a second where the hand rests", "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 10.0});
  SafetyInput pressed = push(2.0);
  pressed.stiffness_N_per_m(0, 0) = 1000.0;
  pressed.velocity_m_s = {-0.1, 0.0, 0.0};
  (void)tick(chain, dead(push(0.0)));
  for (int ms = 0; ms < 110; ++ms) {  // 2 mm deep while there is no force
    SafetyInput going = dead(pressed);
    going.rendered.force_N.x() = 0.02 * std::min(ms + 1, 100);
    going.motion.moved_m.x() = ms == 0 || ms > 99 ? 0.0 : -2e-5;
    (void)tick(chain, going);
  }
  CHECK(after(chain, pressed, 101).x_N() < 1.6);  // some was felt before it had faded
  pressed.velocity_m_s.setZero();
  CHECK(after(chain, pressed, 1001).x_N() == 2.0);
}

}  // namespace
}  // namespace stillgrid::safety::slew_limit_test
