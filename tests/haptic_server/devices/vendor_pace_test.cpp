#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdint>
#include <string>
#include <thread>

#include "tests/haptic_server/devices/plugin.hpp"

namespace stillgrid::devices::vendor_pace_test {
namespace {

/// A vendor's device of ours in the place of a real one.
struct VendorDevice : Plugin {
  VendorDevice(const std::string& plugin, const std::string& fake)
      : Plugin(plugin, nullptr, STILLGRID_CLOCK_MONOTONIC) {
    REQUIRE(configure("library", std::string(STILLGRID_FAKE_VENDOR_DIR) + "/" + fake + ".so") ==
            STILLGRID_DEVICE_OK);
  }
};

std::uint64_t now_ns() {
  return static_cast<std::uint64_t>(
      std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count());
}

/// A host whose tick reads the device and pushes it off the plane z = 0, at 500 N/m.
struct Host {
  VendorDevice& device;
  std::atomic<int> ticks = 0;
  std::atomic<int> last_tick = 1'000'000'000;
  std::atomic<bool> is_wrong = false;
  std::atomic<double> deepest_m = 1.0;
  std::thread::id thread{};

  std::int32_t tick() {
    stillgrid_device_state state{};
    state.struct_size = sizeof state;
    thread = std::this_thread::get_id();
    if (device.api.read(device.device, now_ns(), &state) != STILLGRID_DEVICE_OK) is_wrong = true;
    deepest_m = std::min(deepest_m.load(), state.position_m[2]);
    const std::array<double, 3> force_N{0.0, 0.0, std::max(0.0, -500.0 * state.position_m[2])};
    if (device.api.write(device.device, now_ns(), force_N.data(), nullptr) != STILLGRID_DEVICE_OK)
      is_wrong = true;
    return ++ticks < last_tick ? 0 : 1;
  }
};

TEST_CASE("The vendor's thread runs the tick, which feels what it has just read, until it ends",
          "[vendor]") {
  VendorDevice device("openhaptics", "fake_hd");
  CHECK((device.describe().flags & STILLGRID_DEVICE_SETS_PACE) != 0);
  Host host{device};
  const auto tick = [](void* context) { return static_cast<Host*>(context)->tick(); };
  REQUIRE(device.api.set_tick(device.device, tick, &host) == STILLGRID_DEVICE_OK);
  REQUIRE(device.api.activate(device.device) == STILLGRID_DEVICE_OK);
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  CHECK(host.ticks > 100);
  host.last_tick = 0;
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const int ticks = host.ticks;
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  CHECK(host.ticks == ticks);
  REQUIRE(device.api.deactivate(device.device) == STILLGRID_DEVICE_OK);
  CHECK(host.thread != std::this_thread::get_id());
  CHECK(!host.is_wrong);
  CHECK(host.deepest_m > -0.009);  // the hand would have come to -0.01
  CHECK(host.deepest_m < -0.001);
}

TEST_CASE("No tick comes after deactivate, and the pace is taken back by none", "[vendor]") {
  VendorDevice device("openhaptics", "fake_hd");
  Host host{device};
  const auto tick = [](void* context) { return static_cast<Host*>(context)->tick(); };
  REQUIRE(device.api.set_tick(device.device, tick, &host) == STILLGRID_DEVICE_OK);
  for (int life = 0; life < 3; ++life) {
    REQUIRE(device.api.activate(device.device) == STILLGRID_DEVICE_OK);
    REQUIRE(device.api.deactivate(device.device) == STILLGRID_DEVICE_OK);
    const int ticks = host.ticks;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    CHECK(host.ticks == ticks);
  }
  const int ticks = host.ticks;
  REQUIRE(device.api.set_tick(device.device, nullptr, nullptr) == STILLGRID_DEVICE_OK);
  REQUIRE(device.api.activate(device.device) == STILLGRID_DEVICE_OK);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  CHECK(device.read(now_ns()) == STILLGRID_DEVICE_OK);
  CHECK(host.ticks == ticks);
}

TEST_CASE("A vendor's devices are listed with what opens each", "[vendor]") {
  const auto listed = [](const std::string& plugin, const std::string& fake) {
    VendorDevice device(plugin, fake);
    stillgrid_device_listing listing{};
    listing.struct_size = sizeof listing;
    REQUIRE(device.api.list(device.device, 0, &listing) == STILLGRID_DEVICE_OK);
    stillgrid_device_listing none{};
    none.struct_size = sizeof none;
    CHECK(device.api.list(device.device, 1, &none) == STILLGRID_DEVICE_E_NO_DEVICE);
    const std::string options = listing.options;
    CHECK(options.find(std::string("serial=") + listing.serial) != std::string::npos);
    REQUIRE(device.configure("serial", listing.serial) == STILLGRID_DEVICE_OK);
    CHECK(device.identity().serial == std::string(listing.serial));
    return std::string(listing.name);
  };
  CHECK(listed("force_dimension", "fake_dhd") == "omega.7");
  CHECK(listed("openhaptics", "fake_hd") == "Touch");
}

TEST_CASE("Orders are taken while active, and others refused with a line", "[vendor]") {
  VendorDevice device("force_dimension", "fake_dhd");
  CHECK(device.api.command(device.device, "gravity_compensation", "0") == STILLGRID_DEVICE_E_ORDER);
  REQUIRE(device.api.activate(device.device) == STILLGRID_DEVICE_OK);
  CHECK(device.api.command(device.device, "gravity_compensation", "0") == STILLGRID_DEVICE_OK);
  CHECK(device.api.command(device.device, "dance", "1") == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(device.line().find("dance") != std::string::npos);
}

}  // namespace
}  // namespace stillgrid::devices::vendor_pace_test
