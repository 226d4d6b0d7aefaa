#include "haptic_server/safety/device_reading.hpp"

#include <catch2/catch.hpp>
#include <limits>

namespace stillgrid::safety::device_reading_test {
namespace {

constexpr std::uint64_t kMillisecond_ns = 1'000'000;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

stillgrid_device_state state_at(std::uint64_t time_ns, double x_m) {
  static std::uint64_t sequence = 0;
  stillgrid_device_state state{};
  state.struct_size = sizeof state;
  state.sequence = ++sequence;
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

TEST_CASE("What a device tells of itself counts as far as it knows it", "[device_reading]") {
  // Every status that a driver may tell, with every share of it known, and bits of a later header.
  constexpr std::uint32_t kGood =
      STILLGRID_STATUS_MOTORS_ON | STILLGRID_STATUS_ENABLED | STILLGRID_STATUS_CALIBRATED;
  const std::uint32_t later = GENERATE(0U, 1U << 5U, 1U << 31U);
  for (std::uint32_t status = 0; status < 32; ++status)
    for (std::uint32_t known = 0; known < 32; ++known) {
      stillgrid_device_state state = state_at(0, 0.0);
      state.status = status | later;
      state.status_known = known | later;
      const std::uint32_t bad = (status ^ kGood) & known;  // of what should be, what is not
      CHECK(status_flags(state) == bad * kFlagMotorsOff);  // bit by bit in the same order
    }
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
  constexpr std::uint64_t now_ns = 500 * kMillisecond_ns;
  const auto time_of = [](std::uint64_t stamp_ns) {
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

TEST_CASE("An orientation that is no unit quaternion is not believed", "[device_reading]") {
  DeviceReadingCheck check;
  stillgrid_device_state state = state_at(0, 0.1);
  state.orientation_xyzw[0] = kNaN;  // not marked valid
  CHECK(check.check(state, 0));
  state.valid |= STILLGRID_STATE_ORIENTATION;
  CHECK_FALSE(check.check(state, 0));
  CHECK(check.reason() == kFlagNoOrientation);
  state.orientation_xyzw[0] = 0.0;
  state.orientation_xyzw[3] = 1.1;
  CHECK_FALSE(check.check(state, 0));
  state.orientation_xyzw[3] = 1.0;
  const auto reading = check.check(state, 0);
  REQUIRE(reading);
  CHECK(reading->orientation);
  CHECK(check.reason() == 0);
}

TEST_CASE("Each cause has a reason of its own", "[device_reading]") {
  std::uint64_t now_ns = 0;
  DeviceReadingCheck check = used(now_ns);
  stillgrid_device_state bad = state_at(now_ns, 0.0);
  std::uint32_t reason = 0;
  SECTION("missing") {
    bad.valid = 0;
    reason = kFlagNoPosition;
  }
  SECTION("no number") {
    bad.position_m[2] = kNaN;
    reason = kFlagNoNumber;
  }
  SECTION("far") {
    bad.position_m[1] = -11.0;
    reason = kFlagTooFar;
  }
  SECTION("back") {
    bad.time_ns -= 3 * kMillisecond_ns;
    reason = kFlagStampBack;
  }
  SECTION("ahead") {
    bad.time_ns += 101 * kMillisecond_ns;
    reason = kFlagStampOff;
  }
  SECTION("leap") {
    bad.position_m[1] = 0.3;
    reason = kFlagLeap;
  }
  CHECK_FALSE(check.check(bad, now_ns));
  CHECK(check.reason() == reason);
  CHECK((reason & kDeviceReasonMask) != 0);
}

TEST_CASE("A sequence that stands still for 100 ms under fresh stamps is not believed",
          "[device_reading]") {
  std::uint64_t now_ns = 0;
  DeviceReadingCheck check = used(now_ns);
  const stillgrid_device_state frozen = state_at(now_ns, 0.0);
  for (int ms = 0; ms <= 100; ++ms, now_ns += kMillisecond_ns) {
    stillgrid_device_state fresh = frozen;
    fresh.time_ns = now_ns;
    CHECK(check.check(fresh, now_ns));
  }
  stillgrid_device_state fresh = frozen;
  fresh.time_ns = now_ns;
  CHECK_FALSE(check.check(fresh, now_ns));
  CHECK(check.reason() == kFlagFrozen);
  CHECK(check.check(state_at(now_ns, 0.0), now_ns));
}

ReadingBounds declared_bounds() {
  ReadingBounds bounds;
  bounds.workspace = {{-0.1, 0.0, -0.02}, {0.1, 0.0, 0.02}};
  bounds.max_speed_m_s = 1.0;
  return bounds;
}

TEST_CASE("A position far outside the declared workspace is not believed", "[device_reading]") {
  const auto reason_at = [](double x_m, double y_m, double z_m) {
    DeviceReadingCheck check(declared_bounds());
    stillgrid_device_state state = state_at(0, x_m);
    state.position_m[1] = y_m;
    state.position_m[2] = z_m;
    (void)check.check(state, 0);
    return check.reason();
  };
  CHECK(reason_at(0.19, 0.0, 0.0) == 0);  // out of it, but a device may be
  CHECK(reason_at(0.21, 0.0, 0.0) == kFlagOutside);
  CHECK(reason_at(-0.21, 0.0, 0.0) == kFlagOutside);
  CHECK(reason_at(0.0, 5.0, 0.0) == 0);  // no extent, no edge
  CHECK(reason_at(0.0, 0.0, 0.069) == 0);
  CHECK(reason_at(0.0, 0.0, 0.071) == kFlagOutside);
}

TEST_CASE("A device leaps where it is three times faster than it declares, since its last sample",
          "[device_reading]") {
  const std::uint64_t samples_ms = GENERATE(1U, 10U);  // a device of 1 kHz, and one of 100 Hz
  const double bound_m = 1e-3 + 3.0 * 1e-3 * static_cast<double>(samples_ms);
  const double slip_m = GENERATE_COPY(0.9 * bound_m, 1.1 * bound_m);
  DeviceReadingCheck check(declared_bounds());
  stillgrid_device_state state = state_at(0, 0.0);
  for (std::uint64_t ms = 0; ms < 100; ++ms) {
    if (ms % samples_ms == 0) state = state_at(0, 0.0);
    state.time_ns = ms * kMillisecond_ns;
    REQUIRE(check.check(state, state.time_ns));
  }
  CHECK(check.check(state_at(100 * kMillisecond_ns, slip_m), 100 * kMillisecond_ns).has_value() ==
        (slip_m < bound_m));
}

}  // namespace
}  // namespace stillgrid::safety::device_reading_test
