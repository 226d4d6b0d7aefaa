#include "haptic_server/safety/device_reading.hpp"

#include <catch2/catch.hpp>
#include <limits>

namespace stillgrid {
namespace {

constexpr std::uint64_t kMillisecond_ns = 1'000'000;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

stillgrid_device_state state_at(std::uint64_t time_ns, double x_m) {
  stillgrid_device_state state{};
  state.struct_size = sizeof state;
  state.valid = STILLGRID_STATE_POSITION;
  state.time_ns = time_ns;
  state.position_m[0] = x_m;
  return state;
}

/// A check that has believed a second of readings at x = 0.
DeviceReadingCheck used(std::uint64_t& now_ns) {
  DeviceReadingCheck check;
  for (now_ns = 0; now_ns < 1000 * kMillisecond_ns; now_ns += kMillisecond_ns)
    REQUIRE(check.check(state_at(now_ns, 0.0), now_ns));
  return check;
}

TEST_CASE("A position that is missing, no number or out of the room is not believed",
          "[device_reading]") {
  std::uint64_t now_ns = 0;
  DeviceReadingCheck check = used(now_ns);
  stillgrid_device_state bad = state_at(now_ns, 0.0);
  SECTION("missing") {
    bad.valid = 0;
  }
  SECTION("no number") {
    bad.position_m[2] = kNaN;
  }
  SECTION("endless") {
    bad.position_m[1] = std::numeric_limits<double>::infinity();
  }
  SECTION("far") {
    bad.position_m[1] = 11.0;
  }
  CHECK_FALSE(check.check(bad, now_ns));
  CHECK(check.check(state_at(now_ns, 0.0), now_ns));
}

TEST_CASE("A stamp that goes back, or is far from now, is not believed", "[device_reading]") {
  std::uint64_t now_ns = 0;
  DeviceReadingCheck check = used(now_ns);
  CHECK_FALSE(check.check(state_at(now_ns - 3 * kMillisecond_ns, 0.0), now_ns));
  CHECK_FALSE(check.check(state_at(now_ns + 101 * kMillisecond_ns, 0.0), now_ns));
  CHECK(check.check(state_at(now_ns, 0.0), now_ns));
  const std::uint64_t frozen_ns = now_ns;
  CHECK(check.check(state_at(frozen_ns, 0.0), frozen_ns + 100 * kMillisecond_ns));
  CHECK_FALSE(check.check(state_at(frozen_ns, 0.0), frozen_ns + 101 * kMillisecond_ns));
}

TEST_CASE("A leap is not believed before it has lasted 100 ms", "[device_reading]") {
  std::uint64_t now_ns = 0;
  DeviceReadingCheck check = used(now_ns);
  const double there_m = GENERATE(0.05, 0.5, 3.0);
  std::uint64_t since_ns = 0;
  for (; !check.check(state_at(now_ns, there_m), now_ns); now_ns += kMillisecond_ns)
    since_ns += kMillisecond_ns;
  CHECK(since_ns == 100 * kMillisecond_ns);
  CHECK(check.check(state_at(now_ns, there_m), now_ns)->position_m.x() == there_m);
}

TEST_CASE("A glitch of one reading is left out, and the motion goes on", "[device_reading]") {
  std::uint64_t now_ns = 0;
  DeviceReadingCheck check = used(now_ns);
  CHECK_FALSE(check.check(state_at(now_ns, 0.5), now_ns));
  now_ns += kMillisecond_ns;
  CHECK(check.check(state_at(now_ns, 0.002), now_ns));
}

TEST_CASE("A reading has its sample's time if that is at most 10 ms ago", "[device_reading]") {
  const std::uint64_t now_ns = 500 * kMillisecond_ns;
  const auto time_of = [now_ns](std::uint64_t stamp_ns) {
    DeviceReadingCheck check;
    return check.check(state_at(stamp_ns, 0.0), now_ns)->time_ns;
  };
  CHECK(time_of(now_ns) == now_ns);
  CHECK(time_of(now_ns - 10 * kMillisecond_ns) == now_ns - 10 * kMillisecond_ns);
  CHECK(time_of(now_ns - 11 * kMillisecond_ns) == now_ns);
  CHECK(time_of(now_ns + kMillisecond_ns) == now_ns);
}

TEST_CASE("A fast hand is believed", "[device_reading]") {
  DeviceReadingCheck check;
  for (std::uint64_t ms = 0; ms < 200; ++ms)
    CHECK(check.check(state_at(ms * kMillisecond_ns, 5e-3 * static_cast<double>(ms)),
                      ms * kMillisecond_ns));
}

TEST_CASE("An orientation that is not of unit length is left out, the position kept",
          "[device_reading]") {
  DeviceReadingCheck check;
  stillgrid_device_state state = state_at(0, 0.1);
  state.valid |= STILLGRID_STATE_ORIENTATION;
  state.orientation_xyzw[3] = 1.0;
  CHECK(check.check(state, 0)->orientation);
  state.orientation_xyzw[3] = 1.1;
  const auto reading = check.check(state, 0);
  REQUIRE(reading);
  CHECK_FALSE(reading->orientation);
  state.orientation_xyzw[0] = kNaN;
  CHECK_FALSE(check.check(state, 0)->orientation);
}

}  // namespace
}  // namespace stillgrid
