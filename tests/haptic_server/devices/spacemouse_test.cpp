#include <array>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/haptic_server/devices/allocation_counter.hpp"
#include "tests/haptic_server/devices/fake_spacenavd.hpp"
#include "tests/haptic_server/devices/logging_host.hpp"
#include "tests/haptic_server/devices/plugin.hpp"

namespace stillgrid::devices::spacemouse_test {
namespace {

/// A SpaceMouse at the origin that moves as it is pushed, without a dead zone.
struct Mouse : Plugin {
  Mouse() : Plugin("spacemouse", logging_host, STILLGRID_CLOCK_MONOTONIC) {
    for (const auto& [key, value] : std::vector<std::pair<std::string, std::string>>{
             {"dead_zone", "0"}, {"start_z_m", "0"}, {"range_m", "1"}, {"full_scale", "400"}}) {
      REQUIRE(configure(key, value) == STILLGRID_DEVICE_OK);
    }
  }
  void activate() { REQUIRE(api.activate(device) == STILLGRID_DEVICE_OK); }

  /// Reads, time standing still, until these buttons are down: so all events before have come.
  bool wait_for_buttons(std::uint64_t now_ns, std::uint32_t down) {
    return wait_until([&] { return read(now_ns) == STILLGRID_DEVICE_OK && state.buttons == down; });
  }
};

TEST_CASE("A cap held aside moves the tool at its speed for as long as it is held",
          "[spacemouse]") {
  FakeSpacenavd daemon;
  Mouse mouse;
  mouse.activate();
  REQUIRE(mouse.read(0) == STILLGRID_DEVICE_OK);
  daemon.motion({400, 0, 0, 0, 0, 0});
  daemon.button(2, true);
  REQUIRE(mouse.wait_for_buttons(0, 4));
  for (std::uint64_t n = 1; n <= 1000; ++n) REQUIRE(mouse.read(n * kTick_ns) == 0);
  CHECK(mouse.state.position_m[0] == Approx(0.1));  // 0.1 m/s, a second
  CHECK(mouse.state.position_m[1] == 0.0);
  CHECK(mouse.state.valid ==
        (STILLGRID_STATE_POSITION | STILLGRID_STATE_ORIENTATION | STILLGRID_STATE_BUTTONS));

  daemon.motion({0, 0, 0, 0, 0, 200});
  daemon.button(2, false);
  REQUIRE(mouse.wait_for_buttons(1000 * kTick_ns, 0));
  for (std::uint64_t n = 1001; n <= 2000; ++n) REQUIRE(mouse.read(n * kTick_ns) == 0);
  CHECK(mouse.state.position_m[0] == Approx(0.1));
  CHECK(mouse.state.orientation_xyzw[1] == Approx(std::sin(0.25)));  // 0.5 rad about y
}

TEST_CASE("A stall does not make the tool leap", "[spacemouse]") {
  FakeSpacenavd daemon;
  Mouse mouse;
  mouse.activate();
  daemon.motion({400, 0, 0, 0, 0, 0});
  daemon.button(0, true);
  REQUIRE(mouse.wait_for_buttons(0, 1));
  REQUIRE(mouse.read(10'000 * kTick_ns) == STILLGRID_DEVICE_OK);
  CHECK(mouse.state.position_m[0] == Approx(0.005));  // of 50 ms, not of ten seconds
}

TEST_CASE("A daemon older than its protocol's version serves too", "[spacemouse]") {
  FakeSpacenavd daemon(FakeSpacenavd::Manners::kOld);
  Mouse mouse;
  mouse.activate();
  daemon.button(31, true);
  CHECK(mouse.wait_for_buttons(0, 1U << 31U));
}

TEST_CASE("What a daemon sends that is no event of ours is left alone", "[spacemouse]") {
  FakeSpacenavd daemon;
  Mouse mouse;
  mouse.activate();
  daemon.send_event({99, 1, 2, 3, 4, 5, 6, 7});
  daemon.send_event({-1, 1, 2, 3, 4, 5, 6, 7});
  daemon.button(32, true);
  daemon.button(-1, true);
  daemon.button(1, true);
  CHECK(mouse.wait_for_buttons(0, 2));
}

TEST_CASE("A mouse that is unplugged lets go, and its daemon stays", "[spacemouse]") {
  FakeSpacenavd daemon;
  Mouse mouse;
  mouse.activate();
  daemon.motion({400, 0, 0, 0, 0, 0});
  daemon.button(0, true);
  REQUIRE(mouse.wait_for_buttons(0, 1));
  daemon.unplug();
  REQUIRE(mouse.wait_for_buttons(0, 0));
  REQUIRE(mouse.read(10 * kTick_ns) == STILLGRID_DEVICE_OK);
  CHECK(mouse.state.position_m[0] == 0.0);
  CHECK(wait_until([] { return driver_log.has("unplugged"); }));
}

TEST_CASE("A daemon that goes is a fault of the device, and the tool stands still",
          "[spacemouse]") {
  FakeSpacenavd daemon;
  Mouse mouse;
  mouse.activate();
  daemon.motion({400, 0, 0, 0, 0, 0});
  daemon.button(0, true);
  REQUIRE(mouse.wait_for_buttons(0, 1));
  daemon.hang_up();
  REQUIRE(wait_until([&] { return mouse.read(0) == STILLGRID_DEVICE_E_IO; }));
  CHECK(mouse.read(10 * kTick_ns) == STILLGRID_DEVICE_E_IO);
  CHECK(mouse.state.position_m[0] == 0.0);
  CHECK(wait_until([] { return driver_log.has("spacenavd has gone"); }));
  CHECK(mouse.api.deactivate(mouse.device) == STILLGRID_DEVICE_OK);
}

TEST_CASE("A daemon that hangs up at once does not take the server along", "[spacemouse]") {
  FakeSpacenavd daemon(FakeSpacenavd::Manners::kHangsUp);
  Mouse mouse;
  const std::int32_t code = mouse.api.activate(mouse.device);
  CHECK((code == STILLGRID_DEVICE_E_NO_DEVICE ||
         wait_until([&] { return mouse.read(0) == STILLGRID_DEVICE_E_IO; })));
}

TEST_CASE("Without a daemon there is no device, and it says where one was sought", "[spacemouse]") {
  if (std::filesystem::exists("/var/run/spnav.sock")) {
    WARN("skipped: a spacenavd runs here");
    return;
  }
  const Mouse mouse;
  REQUIRE(mouse.api.activate(mouse.device) == STILLGRID_DEVICE_E_NO_DEVICE);
  CHECK(mouse.line(STILLGRID_DEVICE_E_NO_DEVICE).find("$SPNAV_SOCKET") != std::string::npos);
}

TEST_CASE("A mouse may be activated again, and takes forces without effect", "[spacemouse]") {
  Mouse mouse;
  for (int round = 0; round < 2; ++round) {
    const FakeSpacenavd daemon;
    mouse.activate();
    CHECK(mouse.write(0, 1.0, 2.0, 3.0) == STILLGRID_DEVICE_OK);
    REQUIRE(mouse.read(kTick_ns) == STILLGRID_DEVICE_OK);
    CHECK(mouse.state.position_m[0] == 0.0);
    CHECK(mouse.state.sequence == 1);
    CHECK(mouse.api.deactivate(mouse.device) == STILLGRID_DEVICE_OK);
  }
  CHECK(mouse.describe().max_force_N == 0.0);
  CHECK(std::string(mouse.identity().driver).starts_with("stillgrid spacemouse"));
}

TEST_CASE("A second mouse is refused while the first is in use, and not after", "[spacemouse]") {
  const FakeSpacenavd daemon;
  Mouse first;
  Mouse second;
  first.activate();
  REQUIRE(second.api.activate(second.device) == STILLGRID_DEVICE_E_NO_DEVICE);
  CHECK(second.line(STILLGRID_DEVICE_E_NO_DEVICE).find("already in use") != std::string::npos);
  CHECK(first.read(0) == STILLGRID_DEVICE_OK);
  REQUIRE(first.api.deactivate(first.device) == STILLGRID_DEVICE_OK);
  const FakeSpacenavd next_daemon;
  second.activate();
}

TEST_CASE("An emergency stop holds the tool until the next activation", "[spacemouse]") {
  FakeSpacenavd daemon;
  Mouse mouse;
  mouse.activate();
  daemon.motion({400, 0, 0, 0, 0, 0});
  daemon.button(0, true);
  REQUIRE(mouse.wait_for_buttons(0, 1));
  mouse.api.emergency_stop(mouse.device);
  REQUIRE(mouse.read(10 * kTick_ns) == STILLGRID_DEVICE_OK);
  CHECK(mouse.state.position_m[0] == 0.0);
}

TEST_CASE("Reading a mouse never allocates, events coming in or not", "[spacemouse]") {
  if (!allocation_count()) {
    WARN("skipped: only the address sanitizer counts allocations");
    return;
  }
  FakeSpacenavd daemon;
  Mouse mouse;
  mouse.activate();
  daemon.motion({100, 50, 20, 10, 5, 1});
  daemon.button(0, true);
  REQUIRE(mouse.wait_for_buttons(0, 1));
  const auto before = allocation_count();
  for (std::uint64_t n = 1; n < 100; ++n) static_cast<void>(mouse.read(n * kTick_ns));
  const auto after = allocation_count();
  CHECK(after == before);
}

TEST_CASE("Options of the mouse that cannot be meant are refused by name", "[spacemouse]") {
  const Mouse mouse;
  CHECK(mouse.configure("dead_zone", "1") == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(mouse.line() == "dead_zone: value '1': expected less than 1");
  CHECK(mouse.configure("full_scale", "0") == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(mouse.configure("speed", "1") == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(mouse.line().find("speed_m_s") != std::string::npos);
}

TEST_CASE("In virtual time there is no hand to follow: it is refused", "[spacemouse]") {
  const Plugin in_lockstep("spacemouse");
  CHECK(in_lockstep.api.activate(in_lockstep.device) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(in_lockstep.line().find("lockstep") != std::string::npos);
}

}  // namespace
}  // namespace stillgrid::devices::spacemouse_test
