#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "shared/publication/mouse_segment.hpp"
#include "tests/haptic_server/devices/logging_host.hpp"
#include "tests/haptic_server/devices/plugin.hpp"
#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::devices::mouse_test {
namespace {

constexpr auto kKind = proto::SegmentKind::kMouse;
constexpr std::uint64_t kStart_ns = 5'000 * kTick_ns;

std::string served_session;  // of the host; empty: none

/// A host that keeps what the driver logs, and serves a session.
const void* serving_host(const char* name) {
  static stillgrid_host_session session{sizeof session, 0, nullptr};
  session.name = served_session.c_str();
  return std::strcmp(name, STILLGRID_HOST_SESSION) == 0 ? &session : logging_host(name);
}

/// The device in a session of its own, in the test's time.
struct Mouse {
  Mouse() {
    served_session = session.name();
    plugin.emplace("mouse", serving_host, STILLGRID_CLOCK_MONOTONIC);
  }
  void activate() const { REQUIRE(plugin->api.activate(plugin->device) == STILLGRID_DEVICE_OK); }
  void read(std::uint64_t now_ns) { REQUIRE(plugin->read(now_ns) == STILLGRID_DEVICE_OK); }
  [[nodiscard]] bool is_held() const {
    return (plugin->state.status & STILLGRID_STATUS_ENABLED) != 0;
  }
  /// Once a page's segment has been found: asks in standing time.
  bool wait_for_hold(std::uint64_t now_ns, bool is_wanted) {
    return wait_until([&] {
      read(now_ns);
      return is_held() == is_wanted;
    });
  }
  [[nodiscard]] publication::MouseWriter page() const {
    return publication::MouseWriter(publication::SessionLock(session.name(), kKind));
  }

  publication::TestSession session;
  std::optional<Plugin> plugin;
};

proto::MousePose pose_at(double x_m, std::uint64_t time_ns) {
  return {.time_ns = time_ns,
          .position_m = {x_m, 0.0, 0.03},
          .orientation_xyzw = {0.0, 0.0, 0.0, 1.0},
          .buttons = 1};
}

TEST_CASE("The device follows the page of the host's session, and rests once its viewer has ended",
          "[mouse]") {
  Mouse mouse;
  mouse.activate();
  mouse.read(kStart_ns);
  CHECK_FALSE(mouse.is_held());
  CHECK(mouse.plugin->state.status_known == STILLGRID_STATUS_ENABLED);
  {
    auto page = mouse.page();
    page.publish(pose_at(0.1, kStart_ns));
    REQUIRE(mouse.wait_for_hold(kStart_ns, true));
    CHECK(mouse.plugin->state.buttons == 1);
    for (std::uint64_t n = 1; n <= 400; ++n) mouse.read(kStart_ns + n * kTick_ns);
    CHECK(mouse.plugin->state.position_m[0] == Approx(0.1).margin(1e-3));
  }
  REQUIRE(mouse.wait_for_hold(kStart_ns + 401 * kTick_ns, false));
  CHECK(mouse.plugin->state.buttons == 0);
  auto next = mouse.page();  // of the next viewer
  next.publish(pose_at(0.1, kStart_ns + 401 * kTick_ns));
  CHECK(mouse.wait_for_hold(kStart_ns + 401 * kTick_ns, true));
}

TEST_CASE("Poses that are none move nothing, and hold nothing", "[mouse]") {
  Mouse mouse;
  mouse.activate();
  auto page = mouse.page();
  page.publish(pose_at(0.0, kStart_ns));
  REQUIRE(mouse.wait_for_hold(kStart_ns, true));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  std::uint64_t now_ns = kStart_ns;
  const auto is_followed = [&](const proto::MousePose& pose) {
    now_ns += 2 * kTick_ns;
    proto::MousePose stamped = pose;
    stamped.time_ns = now_ns;
    page.publish(stamped);
    mouse.read(now_ns);
    return mouse.is_held();
  };
  CHECK(is_followed(pose_at(0.0, 0)));
  for (const double bad : {nan, infinite, -infinite, 1e300, 10.1}) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      proto::MousePose pose = pose_at(0.0, 0);
      pose.position_m[axis] = bad;
      CHECK_FALSE(is_followed(pose));
    }
    for (std::size_t i = 0; i < 4; ++i) {
      proto::MousePose pose = pose_at(0.0, 0);
      pose.orientation_xyzw[i] = bad;
      CHECK_FALSE(is_followed(pose));
    }
  }
  CHECK_FALSE(is_followed({}));
  CHECK(is_followed(pose_at(0.0, 0)));
  CHECK(mouse.plugin->state.position_m[0] == Approx(0.0).margin(1e-9));
}

TEST_CASE("A segment of another layout is refused in one line", "[mouse]") {
  Mouse mouse;
  publication::SegmentSpec spec = publication::small_spec(kKind);
  publication::SegmentWriter other(mouse.session.name(), spec);
  other.announce();
  mouse.activate();
  CHECK(wait_until([] { return driver_log.has("another layout"); }));
  mouse.read(kStart_ns);
  CHECK_FALSE(mouse.is_held());
}

TEST_CASE("A force pushes the handle out, and a stop takes it away", "[mouse]") {
  Mouse mouse;
  mouse.activate();
  auto page = mouse.page();
  std::uint64_t now_ns = kStart_ns;
  const auto run = [&](int ticks, double force_N) {
    for (int n = 0; n < ticks; ++n) {
      now_ns += kTick_ns;
      page.publish(pose_at(0.0, now_ns));
      mouse.read(now_ns);
      REQUIRE(mouse.plugin->write(now_ns, force_N, 0.0, 0.0) == STILLGRID_DEVICE_OK);
    }
  };
  page.publish(pose_at(0.0, kStart_ns));
  REQUIRE(mouse.wait_for_hold(kStart_ns, true));
  run(1000, 2.0);
  CHECK(mouse.plugin->state.position_m[0] == Approx(2.0 / 400.0).epsilon(1e-3));
  mouse.plugin->api.emergency_stop(mouse.plugin->device);
  run(1000, 2.0);
  CHECK(mouse.plugin->state.position_m[0] == Approx(0.0).margin(1e-6));
  CHECK(mouse.plugin->write(now_ns, std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0) ==
        STILLGRID_DEVICE_E_ARGUMENT);
}

TEST_CASE("The mouse declares what it is good for, and refuses what cannot be meant", "[mouse]") {
  const Mouse mouse;
  const auto descriptor = mouse.plugin->describe();
  CHECK(descriptor.max_force_N == 8.0);
  CHECK(descriptor.nominal_stiffness_N_per_m == 3000.0);
  CHECK(descriptor.workspace_max_m[0] == 0.5);
  CHECK((descriptor.flags & STILLGRID_DEVICE_NO_MOTORS) != 0);
  for (const auto& [key, value] : std::vector<std::array<std::string, 2>>{{"pull_N", "0"},
                                                                          {"pull_N", "9"},
                                                                          {"range_m", "6"},
                                                                          {"session", "a/b/c"},
                                                                          {"path", "nowhere"},
                                                                          {"speed", "1"}})
    CHECK(mouse.plugin->configure(key, value) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(mouse.plugin->line().find("pull_N") != std::string::npos);
  served_session = "";
  const Plugin unserved("mouse", serving_host, STILLGRID_CLOCK_MONOTONIC);
  CHECK(unserved.api.activate(unserved.device) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(unserved.line() == "expected session=NAME");
  const Plugin in_lockstep("mouse", serving_host);
  CHECK(in_lockstep.api.activate(in_lockstep.device) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(in_lockstep.line().find("lockstep") != std::string::npos);
}

}  // namespace
}  // namespace stillgrid::devices::mouse_test
