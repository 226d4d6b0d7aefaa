#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/haptic_server/devices/plugin.hpp"

namespace stillgrid::devices::phantom_test {
namespace {

/// A bare mass of 0.1 kg at the origin.
void make_bare(const Plugin& phantom) {
  for (const auto& [key, value] :
       std::vector<std::pair<std::string, std::string>>{{"hand", "none"},
                                                        {"path", "still"},
                                                        {"centre_z_m", "0"},
                                                        {"mass_kg", "0.1"},
                                                        {"damping_N_s_per_m", "0"},
                                                        {"friction_N", "0"},
                                                        {"resolution_m", "0"}}) {
    REQUIRE(phantom.configure(key, value) == STILLGRID_DEVICE_OK);
  }
}

TEST_CASE("The force written moves the simulated device until the next", "[plugins]") {
  Plugin phantom("phantom");
  make_bare(phantom);
  REQUIRE(phantom.api.activate(phantom.device) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.read(9 * kTick_ns) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.write(9 * kTick_ns, 2.0, 0.0, 0.0) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.read(19 * kTick_ns) == STILLGRID_DEVICE_OK);
  CHECK(phantom.state.position_m[0] == Approx(0.5 * 2.0 / 0.1 * 0.01 * 0.01));
  CHECK(phantom.state.valid == (STILLGRID_STATE_POSITION | STILLGRID_STATE_BUTTONS));

  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(phantom.write(19 * kTick_ns, nan, 0.0, 0.0) == STILLGRID_DEVICE_E_ARGUMENT);
}

TEST_CASE("A device that is held stays at its start, and then begins to move", "[plugins]") {
  Plugin phantom("phantom");
  make_bare(phantom);
  REQUIRE(phantom.configure("hold_s", "0.02") == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.configure("velocity_x_m_s", "0.1") == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.api.activate(phantom.device) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.write(0, 2.0, 0.0, 0.0) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.read(20 * kTick_ns) == STILLGRID_DEVICE_OK);
  CHECK(phantom.state.position_m[0] == 0.0);
  REQUIRE(phantom.read(30 * kTick_ns) == STILLGRID_DEVICE_OK);
  CHECK(phantom.state.position_m[0] == Approx(0.1 * 0.01 + 0.5 * 2.0 / 0.1 * 0.01 * 0.01));
}

TEST_CASE("An emergency stop takes the force away until the next activation", "[plugins]") {
  Plugin phantom("phantom");
  make_bare(phantom);
  REQUIRE(phantom.configure("delay_ticks", "2") == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.api.activate(phantom.device) == STILLGRID_DEVICE_OK);
  for (std::uint64_t n = 0; n < 5; ++n) REQUIRE(phantom.write(n * kTick_ns, 1, 0, 0) == 0);
  phantom.api.emergency_stop(phantom.device);
  std::vector<double> x_m;
  for (std::uint64_t n = 5; n < 9; ++n) {
    REQUIRE(phantom.read(n * kTick_ns) == STILLGRID_DEVICE_OK);
    REQUIRE(phantom.write(n * kTick_ns, 1, 0, 0) == STILLGRID_DEVICE_OK);
    x_m.push_back(phantom.state.position_m[0]);
  }
  CHECK(x_m[3] - x_m[2] == Approx(x_m[1] - x_m[0]).epsilon(1e-9));  // it only glides

  REQUIRE(phantom.api.deactivate(phantom.device) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.api.activate(phantom.device) == STILLGRID_DEVICE_OK);
  for (std::uint64_t n = 0; n < 9; ++n) REQUIRE(phantom.write(n * kTick_ns, 1, 0, 0) == 0);
  REQUIRE(phantom.read(9 * kTick_ns) == STILLGRID_DEVICE_OK);
  CHECK(phantom.state.position_m[0] > 0.0);
}

TEST_CASE("The order of options does not matter, and a start can be its own", "[plugins]") {
  Plugin phantom("phantom");
  REQUIRE(phantom.configure("start_x_m", "0.5") == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.configure("resolution_m", "0") == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.configure("max_force_N", "1.5") == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.configure("profile", "premium15") == STILLGRID_DEVICE_OK);
  stillgrid_device_descriptor descriptor{};
  descriptor.struct_size = sizeof descriptor;
  REQUIRE(phantom.api.describe(phantom.device, &descriptor) == STILLGRID_DEVICE_OK);
  CHECK(descriptor.max_force_N == 1.5);
  CHECK(descriptor.continuous_force_N == 1.4);
  CHECK(descriptor.rate_hz == 1000.0);
  CHECK(std::string(descriptor.name) == "phantom");

  REQUIRE(phantom.api.activate(phantom.device) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.read(0) == STILLGRID_DEVICE_OK);
  CHECK(phantom.state.position_m[0] == 0.5);
  CHECK(phantom.state.position_m[2] == 0.03);  // of the path
}

TEST_CASE("A stall of 40 ms is caught up with, of a longer one 50 ticks", "[plugins]") {
  Plugin phantom("phantom");
  make_bare(phantom);
  REQUIRE(phantom.configure("velocity_x_m_s", "1") == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.api.activate(phantom.device) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.read(0) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.read(40 * kTick_ns) == STILLGRID_DEVICE_OK);
  CHECK(phantom.state.position_m[0] == Approx(0.040));
  REQUIRE(phantom.read(100'000 * kTick_ns) == STILLGRID_DEVICE_OK);
  CHECK(phantom.state.position_m[0] == Approx(0.090));
  REQUIRE(phantom.read(100'001 * kTick_ns) == STILLGRID_DEVICE_OK);
  CHECK(phantom.state.position_m[0] == Approx(0.091));
}

TEST_CASE("A clock that jitters leads to where an even one does", "[plugins]") {
  Plugin even("phantom");
  Plugin jittered("phantom");
  for (const Plugin* const phantom : {&even, &jittered}) {
    REQUIRE(phantom->configure("path", "circle") == STILLGRID_DEVICE_OK);
    REQUIRE(phantom->configure("resolution_m", "0") == STILLGRID_DEVICE_OK);
    REQUIRE(phantom->api.activate(phantom->device) == STILLGRID_DEVICE_OK);
  }
  REQUIRE(even.read(0) == STILLGRID_DEVICE_OK);
  REQUIRE(jittered.read(0) == STILLGRID_DEVICE_OK);
  std::mt19937 random(5);
  for (std::uint64_t n = 1; n <= 1000; ++n) {
    REQUIRE(even.read(n * kTick_ns) == STILLGRID_DEVICE_OK);
    const bool stalls = n % 100 == 50;
    const bool is_left_out = n % 100 > 50 && n % 100 < 88;  // 38 ticks that the stall took
    if (is_left_out || stalls) continue;
    const std::uint64_t now_ns = n * kTick_ns + random() % 800'000U;
    REQUIRE(jittered.read(now_ns) == STILLGRID_DEVICE_OK);
    REQUIRE(jittered.read(now_ns - random() % 800'000U) == STILLGRID_DEVICE_OK);  // back in time
  }
  REQUIRE(even.read(1002 * kTick_ns) == STILLGRID_DEVICE_OK);
  REQUIRE(jittered.read(1002 * kTick_ns) == STILLGRID_DEVICE_OK);
  for (int axis = 0; axis < 3; ++axis) {
    CHECK(jittered.state.position_m[axis] == even.state.position_m[axis]);
  }
}

TEST_CASE("Every profile declares its limits, and none when told so", "[plugins]") {
  const std::string profile = GENERATE("touch", "touchx", "premium15");
  const Plugin phantom("phantom");
  REQUIRE(phantom.configure("profile", profile) == STILLGRID_DEVICE_OK);
  const stillgrid_device_descriptor limited = phantom.describe();
  CHECK(limited.max_force_N > limited.continuous_force_N);
  CHECK(limited.continuous_force_N > 0.0);
  CHECK(limited.nominal_stiffness_N_per_m >= 1000.0);
  CHECK(limited.motor_time_constant_s > 0.0);
  CHECK(limited.max_speed_m_s > 0.0);
  CHECK(limited.position_resolution_m > 0.0);
  CHECK(limited.max_read_ns > 0);
  for (int axis = 0; axis < 3; ++axis) {
    CHECK(limited.workspace_max_m[axis] >= 0.035);
    CHECK(limited.workspace_min_m[axis] == -limited.workspace_max_m[axis]);
  }

  REQUIRE(phantom.configure("limits", "0") == STILLGRID_DEVICE_OK);
  const stillgrid_device_descriptor open = phantom.describe();
  CHECK(open.max_force_N == limited.max_force_N);  // an option of its own
  CHECK(open.position_resolution_m == limited.position_resolution_m);
  CHECK(open.continuous_force_N == 0.0);
  CHECK(open.nominal_stiffness_N_per_m == 0.0);
  CHECK(open.motor_time_constant_s == 0.0);
  CHECK(open.max_speed_m_s == 0.0);
  for (const double edge_m : open.workspace_max_m) CHECK(edge_m == 0.0);
  CHECK(std::string(phantom.identity().serial) == "simulated");
}

TEST_CASE("The generated paths keep 5 mm from the edge of every workspace, and to its speed",
          "[plugins]") {
  const std::string profile = GENERATE("touch", "touchx", "premium15");
  const std::string hand = GENERATE("light", "measured");
  const std::string path = GENERATE("still", "press", "stroke", "tap", "circle");
  Plugin phantom("phantom");
  REQUIRE(phantom.configure("profile", profile) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.configure("hand", hand) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.configure("path", path) == STILLGRID_DEVICE_OK);
  const stillgrid_device_descriptor device = phantom.describe();
  REQUIRE(phantom.api.activate(phantom.device) == STILLGRID_DEVICE_OK);
  std::array<double, 3> last_m{};
  for (std::uint64_t n = 0; n < 12'000; ++n) {
    REQUIRE(phantom.read(n * kTick_ns) == STILLGRID_DEVICE_OK);
    double step_m2 = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double at_m = phantom.state.position_m[axis];
      REQUIRE(std::abs(at_m) <= device.workspace_max_m[axis] - 0.005);
      step_m2 += (at_m - last_m[axis]) * (at_m - last_m[axis]);
      last_m[axis] = at_m;
    }
    if (n > 0) REQUIRE(std::sqrt(step_m2) * 1e3 < device.max_speed_m_s);
  }
}

}  // namespace
}  // namespace stillgrid::devices::phantom_test
