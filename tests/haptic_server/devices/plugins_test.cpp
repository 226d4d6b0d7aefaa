#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "proto/device_plugin.h"
#include "tests/haptic_server/devices/allocation_counter.hpp"
#include "tests/haptic_server/devices/plugin.hpp"
#include "tests/haptic_server/devices/recording_file.hpp"

namespace stillgrid::devices::plugins_test {
namespace {

TEST_CASE("A call out of the order of life is refused, and harms nothing", "[plugins]") {
  const RecordingFile file(kRecording);
  const std::string name = GENERATE("phantom", "replay");
  Plugin plugin(name);
  if (name == "replay") REQUIRE(plugin.configure("file", file.path()) == STILLGRID_DEVICE_OK);
  CHECK(plugin.read(0) == STILLGRID_DEVICE_E_ORDER);
  CHECK(plugin.write(0, 0, 0, 0) == STILLGRID_DEVICE_E_ORDER);
  CHECK(plugin.api.deactivate(plugin.device) == STILLGRID_DEVICE_E_ORDER);

  REQUIRE(plugin.api.activate(plugin.device) == STILLGRID_DEVICE_OK);
  CHECK(plugin.api.activate(plugin.device) == STILLGRID_DEVICE_E_ORDER);
  CHECK(plugin.configure("scale", "2") == STILLGRID_DEVICE_E_ORDER);
  CHECK(plugin.read(0) == STILLGRID_DEVICE_OK);
  CHECK(plugin.write(0, 0, 0, 0) == STILLGRID_DEVICE_OK);

  REQUIRE(plugin.api.deactivate(plugin.device) == STILLGRID_DEVICE_OK);
  CHECK(plugin.read(0) == STILLGRID_DEVICE_E_ORDER);
  CHECK(plugin.configure("scale", "2") == STILLGRID_DEVICE_OK);
  CHECK(plugin.api.activate(plugin.device) == STILLGRID_DEVICE_OK);
  CHECK(plugin.read(0) == STILLGRID_DEVICE_OK);
}

TEST_CASE("Null arguments are refused", "[plugins]") {
  const Plugin plugin(GENERATE("phantom", "replay"));
  const stillgrid_device_api& api = plugin.api;
  CHECK(api.open(0, nullptr) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(api.configure(nullptr, "a", "b") == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(api.configure(plugin.device, nullptr, "b") == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(api.configure(plugin.device, "a", nullptr) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(api.describe(plugin.device, nullptr) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(api.activate(nullptr) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(api.read(plugin.device, 0, nullptr) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(api.write(plugin.device, 0, nullptr, nullptr) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(api.deactivate(nullptr) == STILLGRID_DEVICE_E_ARGUMENT);
  api.emergency_stop(nullptr);
  api.close(nullptr);
  for (std::int32_t code = -10; code <= 1; ++code) {
    CHECK(api.strerror(nullptr, code) != nullptr);
    CHECK(api.strerror(plugin.device, code) != nullptr);
  }
}

TEST_CASE("There is one device, number 0", "[plugins]") {
  const Plugin plugin(GENERATE("phantom", "replay"));
  stillgrid_device* second = nullptr;
  CHECK(plugin.api.enumerate() == 1);
  CHECK(plugin.api.open(1, &second) == STILLGRID_DEVICE_E_NO_DEVICE);
  CHECK(second == nullptr);
}

TEST_CASE("A driver refuses a struct of another size, untouched", "[plugins]") {
  Plugin plugin("phantom");
  REQUIRE(plugin.api.activate(plugin.device) == STILLGRID_DEVICE_OK);
  stillgrid_device_state state{};
  for (const std::size_t size : {std::size_t{8}, sizeof state - 8, sizeof state + 8}) {
    state.struct_size = static_cast<std::uint32_t>(size);
    CHECK(plugin.api.read(plugin.device, 0, &state) == STILLGRID_DEVICE_E_ARGUMENT);
    CHECK(state.valid == 0);
  }
  stillgrid_device_descriptor descriptor{};
  CHECK(plugin.api.describe(plugin.device, &descriptor) == STILLGRID_DEVICE_E_ARGUMENT);
}

TEST_CASE("Versions must be equal, and a host's struct be whole", "[plugins]") {
  const auto negotiate = negotiator_of(GENERATE("phantom", "replay"));
  stillgrid_device_api api{};
  api.struct_size = sizeof api;
  stillgrid_host_info host{sizeof host, STILLGRID_DEVICE_ABI, STILLGRID_CLOCK_VIRTUAL, 0, kTick_ns,
                           nullptr};
  CHECK(negotiate(&host, &api) == STILLGRID_DEVICE_OK);
  CHECK(api.abi == STILLGRID_DEVICE_ABI);
  for (const std::uint32_t other : {STILLGRID_DEVICE_ABI - 1, STILLGRID_DEVICE_ABI + 1}) {
    host.abi = other;
    CHECK(negotiate(&host, &api) == STILLGRID_DEVICE_E_VERSION);
  }
  host.abi = STILLGRID_DEVICE_ABI;
  host.period_ns = 0;
  CHECK(negotiate(&host, &api) == STILLGRID_DEVICE_E_ARGUMENT);
  host.period_ns = kTick_ns;
  host.struct_size = 8;
  CHECK(negotiate(&host, &api) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(negotiate(nullptr, &api) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(negotiate(&host, nullptr) == STILLGRID_DEVICE_E_ARGUMENT);
}

TEST_CASE("A bad option is refused in one line with key, value and what is expected", "[plugins]") {
  struct Row {
    const char *plugin, *key, *value, *line;
  };
  const auto row = GENERATE(
      Row{"phantom", "hand", "heavy", "hand: value 'heavy': expected none, light or measured"},
      Row{"phantom", "profile", "", "profile: value '': expected touch, touchx or premium15"},
      Row{"phantom", "mass_kg", "0", "mass_kg: value '0': expected more than 0"},
      Row{"phantom", "friction_N", "-1", "friction_N: value '-1': expected 0 or more"},
      Row{"phantom", "push_x_N", "inf", "push_x_N: value 'inf': expected a finite number"},
      Row{"phantom", "delay_ticks", "128",
          "delay_ticks: value '128': expected a whole number from 0 to 127"},
      Row{"phantom", "seed", "-1",
          "seed: value '-1': expected a whole number from 0 to 18446744073709551615"},
      Row{"replay", "loop", "yes", "loop: value 'yes': expected a whole number from 0 to 1"},
      Row{"replay", "resample", "sinc",
          "resample: value 'sinc': expected linear, cubic or band_limited"},
      Row{"replay", "scale", "1,5", "scale: value '1,5': expected a finite number"});
  const Plugin plugin(row.plugin);
  CHECK(plugin.configure(row.key, row.value) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(plugin.line() == row.line);
}

TEST_CASE("An unknown key is refused with the keys there are", "[plugins]") {
  const Plugin plugin(GENERATE("phantom", "replay"));
  CHECK(plugin.configure("colour", "red") == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(plugin.line().starts_with("colour: value 'red': expected a known key: "));
  CHECK(plugin.line().find("knot_spacing_s") != std::string::npos);
}

TEST_CASE("A missing or bad recording is reported before the loop starts", "[plugins]") {
  const Plugin replay("replay");
  stillgrid_device_descriptor descriptor{};
  descriptor.struct_size = sizeof descriptor;
  CHECK(replay.api.describe(replay.device, &descriptor) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(replay.line().find("file=PATH is required") != std::string::npos);
  CHECK(replay.api.activate(replay.device) == STILLGRID_DEVICE_E_ARGUMENT);

  const RecordingFile bad("t_s,x_m,y_m,z_m\n0,0,0,none\n");
  REQUIRE(replay.configure("file", bad.path()) == STILLGRID_DEVICE_OK);
  CHECK(replay.api.activate(replay.device) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(replay.line() == bad.path() + ":2: column z_m: value 'none': expected a finite number");

  const Plugin phantom("phantom");
  REQUIRE(phantom.configure("path", bad.path()) == STILLGRID_DEVICE_OK);
  CHECK(phantom.api.activate(phantom.device) == STILLGRID_DEVICE_E_ARGUMENT);
}

TEST_CASE("The counter of allocations sees those of the plugins", "[plugins]") {
  if (!allocation_count()) {
    WARN("skipped: only the address sanitizer counts allocations");
    return;
  }
  const Plugin plugin(GENERATE("phantom", "replay"));
  stillgrid_device* second = nullptr;
  const auto before = allocation_count();
  const std::int32_t code = plugin.api.open(0, &second);
  const auto after = allocation_count();
  REQUIRE(code == STILLGRID_DEVICE_OK);
  CHECK(after > before);
  plugin.api.close(second);
}

TEST_CASE("Reading and writing never allocate", "[plugins]") {
  if (!allocation_count()) {
    WARN("skipped: only the address sanitizer counts allocations");
    return;
  }
  const RecordingFile file(kRecording);
  const std::string name = GENERATE("phantom", "replay");
  const std::string path = GENERATE("circle", "recorded");
  Plugin plugin(name);
  if (name == "replay") {
    REQUIRE(plugin.configure("file", file.path()) == STILLGRID_DEVICE_OK);
    REQUIRE(plugin.configure("resample", "cubic") == STILLGRID_DEVICE_OK);
  } else {
    REQUIRE(plugin.configure("path", path == "recorded" ? file.path() : path) == 0);
    REQUIRE(plugin.configure("noise_m", "1e-5") == STILLGRID_DEVICE_OK);
  }
  REQUIRE(plugin.api.activate(plugin.device) == STILLGRID_DEVICE_OK);

  const auto before = allocation_count();
  std::int32_t worst = 0;
  for (std::uint64_t n = 0; n < 100; ++n) {
    worst = std::min(worst, plugin.read(n * kTick_ns));
    worst = std::min(worst, plugin.write(n * kTick_ns, 0.1, 0.2, 0.3));
  }
  const auto after = allocation_count();
  CHECK(after == before);
  CHECK(worst == (name == "replay" ? STILLGRID_DEVICE_END : STILLGRID_DEVICE_OK));
}

}  // namespace
}  // namespace stillgrid::devices::plugins_test
