#include <dlfcn.h>

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
#include "tests/haptic_server/devices/recording_file.hpp"

namespace stillgrid {
namespace {

constexpr std::uint64_t kTick_ns = 1'000'000;

stillgrid_device_negotiate_fn negotiator_of(const std::string& plugin) {
  const std::filesystem::path file = std::filesystem::path(STILLGRID_PLUGIN_DIR) / (plugin + ".so");
  void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  REQUIRE(library != nullptr);
  return reinterpret_cast<stillgrid_device_negotiate_fn>(
      dlsym(library, "stillgrid_device_negotiate"));
}

/// A plugin as a host sees it, closed at the end.
struct Plugin {
  explicit Plugin(const std::string& name) {
    const stillgrid_host_info host{sizeof host, 1, 1, STILLGRID_CLOCK_VIRTUAL, kTick_ns};
    api.struct_size = sizeof api;
    REQUIRE(negotiator_of(name)(&host, &api) == STILLGRID_DEVICE_OK);
    REQUIRE(api.open(0, &device) == STILLGRID_DEVICE_OK);
  }
  ~Plugin() { api.close(device); }
  Plugin(const Plugin&) = delete;
  Plugin& operator=(const Plugin&) = delete;

  [[nodiscard]] std::int32_t configure(const std::string& key, const std::string& value) const {
    return api.configure(device, key.c_str(), value.c_str());
  }
  [[nodiscard]] std::string line() const {
    return api.strerror(device, STILLGRID_DEVICE_E_ARGUMENT);
  }
  std::int32_t read(std::uint64_t now_ns) {
    state = {};
    state.struct_size = sizeof state;
    return api.read(device, now_ns, &state);
  }
  [[nodiscard]] std::int32_t write(std::uint64_t now_ns, double x_N, double y_N, double z_N) const {
    const std::array force_N = {x_N, y_N, z_N};
    return api.write(device, now_ns, force_N.data(), nullptr);
  }

  stillgrid_device_api api{};
  stillgrid_device* device = nullptr;
  stillgrid_device_state state{};
};

/// A bare mass of 0.1 kg at the origin.
void make_bare(const Plugin& phantom) {
  for (const auto& [key, value] :
       std::vector<std::pair<std::string, std::string>>{{"hand", "none"},
                                                        {"path", "still"},
                                                        {"centre_z_m", "0"},
                                                        {"mass_kg", "0.1"},
                                                        {"damping_N_s_m", "0"},
                                                        {"friction_N", "0"},
                                                        {"resolution_m", "0"}}) {
    REQUIRE(phantom.configure(key, value) == STILLGRID_DEVICE_OK);
  }
}

const std::string kRecording = "t_s,x_m,y_m,z_m\n5,0,0,1\n5.002,0.2,0,1\n5.004,0.2,0.4,1\n";

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

TEST_CASE("A driver touches only fields inside the caller's struct", "[plugins]") {
  Plugin plugin("phantom");
  REQUIRE(plugin.api.activate(plugin.device) == STILLGRID_DEVICE_OK);

  stillgrid_device_state old{};  // ends after the position
  old.struct_size = offsetof(stillgrid_device_state, orientation_xyzw);
  old.orientation_xyzw[0] = 42.0;
  old.buttons = 42;
  CHECK(plugin.api.read(plugin.device, 0, &old) == STILLGRID_DEVICE_OK);
  CHECK(old.valid == STILLGRID_STATE_POSITION);
  CHECK(old.orientation_xyzw[0] == 42.0);
  CHECK(old.buttons == 42);
  CHECK(old.struct_size == offsetof(stillgrid_device_state, orientation_xyzw));

  struct {
    stillgrid_device_state known;
    std::uint64_t later_field;
  } newer{};
  newer.known.struct_size = sizeof newer;
  newer.later_field = 42;
  CHECK(plugin.api.read(plugin.device, 0, &newer.known) == STILLGRID_DEVICE_OK);
  CHECK(newer.later_field == 42);

  old.struct_size = 8;
  CHECK(plugin.api.read(plugin.device, 0, &old) == STILLGRID_DEVICE_E_ARGUMENT);
  stillgrid_device_descriptor descriptor{};
  CHECK(plugin.api.describe(plugin.device, &descriptor) == STILLGRID_DEVICE_E_ARGUMENT);
}

TEST_CASE("Versions must meet, and a host's struct be whole", "[plugins]") {
  const auto negotiate = negotiator_of(GENERATE("phantom", "replay"));
  stillgrid_device_api api{};
  api.struct_size = sizeof api;
  stillgrid_host_info host{sizeof host, 2, 3, STILLGRID_CLOCK_VIRTUAL, kTick_ns};
  CHECK(negotiate(&host, &api) == STILLGRID_DEVICE_E_VERSION);
  host.abi_min = 0;
  CHECK(negotiate(&host, &api) == STILLGRID_DEVICE_OK);
  CHECK(api.abi == 1);
  host.period_ns = 0;
  CHECK(negotiate(&host, &api) == STILLGRID_DEVICE_E_ARGUMENT);
  host.struct_size = 4;
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
      Row{"replay", "resample", "sinc", "resample: value 'sinc': expected linear or cubic"},
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

TEST_CASE("A recording is replayed from zero and comes to its end", "[plugins]") {
  const RecordingFile file(kRecording);
  Plugin replay("replay");
  REQUIRE(replay.configure("file", file.path()) == STILLGRID_DEVICE_OK);
  REQUIRE(replay.configure("scale", "0.5") == STILLGRID_DEVICE_OK);
  REQUIRE(replay.configure("offset_z_m", "-0.5") == STILLGRID_DEVICE_OK);
  stillgrid_device_descriptor descriptor{};
  descriptor.struct_size = sizeof descriptor;
  REQUIRE(replay.api.describe(replay.device, &descriptor) == STILLGRID_DEVICE_OK);
  CHECK(descriptor.max_force_N == 0.0);
  CHECK(descriptor.workspace_max_m[1] == 0.2);

  constexpr std::uint64_t kStart_ns = 77 * kTick_ns;
  for (int round = 0; round < 2; ++round) {  // activating again starts again
    REQUIRE(replay.api.activate(replay.device) == STILLGRID_DEVICE_OK);
    for (std::uint64_t n = 0; n <= 4; ++n) {
      REQUIRE(replay.read(kStart_ns + n * kTick_ns) == STILLGRID_DEVICE_OK);
      const double x_m = 0.1 * std::min(static_cast<double>(n) / 2.0, 1.0);
      CHECK(replay.state.position_m[0] == Approx(x_m).margin(1e-12));
      CHECK(replay.state.position_m[2] == 0.0);
      CHECK(replay.state.sequence == n + 1);
    }
    CHECK(replay.read(kStart_ns + 5 * kTick_ns) == STILLGRID_DEVICE_END);
    CHECK(replay.state.position_m[1] == 0.2);  // where it ended
    CHECK(replay.write(kStart_ns + 5 * kTick_ns, 1, 1, 1) == STILLGRID_DEVICE_OK);
    REQUIRE(replay.api.deactivate(replay.device) == STILLGRID_DEVICE_OK);
  }
}

TEST_CASE("A looping recording starts over and has no end", "[plugins]") {
  const RecordingFile file(kRecording);
  Plugin replay("replay");
  REQUIRE(replay.configure("file", file.path()) == STILLGRID_DEVICE_OK);
  REQUIRE(replay.configure("loop", "1") == STILLGRID_DEVICE_OK);
  REQUIRE(replay.api.activate(replay.device) == STILLGRID_DEVICE_OK);
  for (std::uint64_t n = 0; n < 20; ++n) REQUIRE(replay.read(n * kTick_ns) == STILLGRID_DEVICE_OK);
  REQUIRE(replay.read(41 * kTick_ns) == STILLGRID_DEVICE_OK);
  CHECK(replay.state.position_m[0] == Approx(0.1));
}

TEST_CASE("The force written moves the simulated device until the next", "[plugins]") {
  Plugin phantom("phantom");
  make_bare(phantom);
  REQUIRE(phantom.api.activate(phantom.device) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.read(9 * kTick_ns) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.write(9 * kTick_ns, 2.0, 0.0, 0.0) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.read(19 * kTick_ns) == STILLGRID_DEVICE_OK);
  CHECK(phantom.state.position_m[0] == Approx(0.5 * 2.0 / 0.1 * 0.01 * 0.01));
  CHECK(phantom.state.valid == STILLGRID_STATE_POSITION);

  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(phantom.write(19 * kTick_ns, nan, 0.0, 0.0) == STILLGRID_DEVICE_E_ARGUMENT);
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

TEST_CASE("After a stall the simulated device goes on without catching up", "[plugins]") {
  Plugin phantom("phantom");
  make_bare(phantom);
  REQUIRE(phantom.configure("velocity_x_m_s", "1") == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.api.activate(phantom.device) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.read(0) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.read(1000 * kTick_ns) == STILLGRID_DEVICE_OK);
  CHECK(phantom.state.position_m[0] == Approx(0.020));
  REQUIRE(phantom.read(1001 * kTick_ns) == STILLGRID_DEVICE_OK);
  CHECK(phantom.state.position_m[0] == Approx(0.021));
}

TEST_CASE("The counter of allocations sees those of the plugins", "[plugins]") {
  if (!allocation_count()) {
    WARN("skipped: a sanitizer keeps allocations from being counted");
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
    WARN("skipped: a sanitizer keeps allocations from being counted");
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
}  // namespace stillgrid
