#include "haptic_server/devices/plugin_support.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <string>
#include <vector>

namespace stillgrid::devices::plugin_support_test {
namespace {

void (*while_activating)() = nullptr;

/// As small as a driver can be. It is at z = 1 m, and says when motors come on.
class SmallDriver {
 public:
  static constexpr const char* kName = "small";

  explicit SmallDriver(const HostLoop& loop) : log_(loop.log) {}

  static void configure(std::string_view key, std::string_view /*value*/) {
    if (key == "absent") throw DriverError(STILLGRID_DEVICE_E_NO_DEVICE, "no daemon answers");
    if (key != "known") throw std::runtime_error("expected known");
  }
  static void describe(stillgrid_device_descriptor& out) { out.max_speed_m_s = 2.0; }
  static void identify(stillgrid_device_identity& out) {
    std::strncpy(out.serial, "007", sizeof out.serial - 1);
    std::strncpy(out.driver, "small 1.0", sizeof out.driver - 1);
  }
  void activate() const {
    if (while_activating != nullptr) while_activating();
    log_.info("motors on");
  }
  static std::int32_t read(std::uint64_t now_ns, bool is_stopped,
                           stillgrid_device_state& state) noexcept {
    state.valid = STILLGRID_STATE_POSITION;
    state.time_ns = now_ns;
    state.position_m[2] = is_stopped ? 0.0 : 1.0;
    return STILLGRID_DEVICE_OK;
  }
  static std::int32_t write(std::uint64_t /*now_ns*/, bool /*is_stopped*/,
                            const double* /*force_N*/, const double* /*torque_N_m*/) noexcept {
    return STILLGRID_DEVICE_OK;
  }
  void deactivate() noexcept {}

 private:
  HostLog log_;
};

using Adapter = PluginAdapter<SmallDriver>;

std::vector<std::string> lines;

void log_line(std::uint32_t severity, const char* line) {
  lines.push_back((severity == STILLGRID_LOG_INFO ? "info: " : "warning: ") + std::string(line));
}

constexpr stillgrid_host_log kLog{sizeof kLog, 0, log_line};

const void* host_extension(const char* name) {
  return std::strcmp(name, STILLGRID_HOST_LOG) == 0 ? &kLog : nullptr;
}

stillgrid_host_info host_info() {
  return {sizeof(stillgrid_host_info),
          STILLGRID_DEVICE_ABI,
          STILLGRID_CLOCK_VIRTUAL,
          0,
          1'000'000,
          host_extension};
}

/// The table as a host of today gets it.
stillgrid_device_api negotiated() {
  const stillgrid_host_info host = host_info();
  stillgrid_device_api api{};
  api.struct_size = sizeof api;
  REQUIRE(Adapter::negotiate(&host, &api) == STILLGRID_DEVICE_OK);
  return api;
}

TEST_CASE("A table of another size is refused untouched", "[plugin_support]") {
  const stillgrid_host_info host = host_info();
  stillgrid_device_api api{};
  for (const std::size_t size : {std::size_t{8}, sizeof api - 8, sizeof api + 8}) {
    api.struct_size = static_cast<std::uint32_t>(size);
    CHECK(Adapter::negotiate(&host, &api) == STILLGRID_DEVICE_E_ARGUMENT);
    CHECK(api.enumerate == nullptr);
  }
}

TEST_CASE("A host that knows no extensions gets a driver that is silent", "[plugin_support]") {
  stillgrid_host_info host = host_info();
  host.get_extension = nullptr;
  stillgrid_device_api api{};
  api.struct_size = sizeof api;
  REQUIRE(Adapter::negotiate(&host, &api) == STILLGRID_DEVICE_OK);
  lines.clear();
  stillgrid_device* device = nullptr;
  REQUIRE(api.open(0, &device) == STILLGRID_DEVICE_OK);
  CHECK(api.activate(device) == STILLGRID_DEVICE_OK);
  CHECK(lines.empty());
  api.close(device);
}

TEST_CASE("What a driver logs reaches the host", "[plugin_support]") {
  const stillgrid_device_api api = negotiated();
  lines.clear();
  stillgrid_device* device = nullptr;
  REQUIRE(api.open(0, &device) == STILLGRID_DEVICE_OK);
  REQUIRE(api.activate(device) == STILLGRID_DEVICE_OK);
  CHECK(lines == std::vector<std::string>{"info: motors on"});
  api.close(device);
}

TEST_CASE("An identity is offered by name, and written inside its struct", "[plugin_support]") {
  const stillgrid_device_api api = negotiated();
  CHECK(api.get_extension("stillgrid.device.identity/2") == nullptr);
  CHECK(api.get_extension(nullptr) == nullptr);
  const auto* const table = static_cast<const stillgrid_device_identity_api*>(
      api.get_extension(STILLGRID_DEVICE_IDENTITY));
  REQUIRE(table != nullptr);
  stillgrid_device* device = nullptr;
  REQUIRE(api.open(0, &device) == STILLGRID_DEVICE_OK);

  stillgrid_device_identity whole{};
  whole.struct_size = sizeof whole;
  CHECK(table->identify(device, &whole) == STILLGRID_DEVICE_OK);
  CHECK(std::string(whole.serial) == "007");
  CHECK(std::string(whole.firmware).empty());
  CHECK(std::string(whole.driver) == "small 1.0");

  stillgrid_device_identity other{};
  CHECK(table->identify(device, &other) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(table->identify(device, nullptr) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(table->identify(nullptr, &whole) == STILLGRID_DEVICE_E_ARGUMENT);
  api.close(device);
}

TEST_CASE("A fault that is not an option's keeps its own code", "[plugin_support]") {
  const stillgrid_device_api api = negotiated();
  stillgrid_device* device = nullptr;
  REQUIRE(api.open(0, &device) == STILLGRID_DEVICE_OK);
  CHECK(api.configure(device, "unknown", "") == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(api.configure(device, "absent", "") == STILLGRID_DEVICE_E_NO_DEVICE);
  CHECK(std::string(api.strerror(device, STILLGRID_DEVICE_E_NO_DEVICE)) == "no daemon answers");
  api.close(device);
}

TEST_CASE("A stop lasts until the next activation", "[plugin_support]") {
  const stillgrid_device_api api = negotiated();
  stillgrid_device* device = nullptr;
  REQUIRE(api.open(0, &device) == STILLGRID_DEVICE_OK);
  REQUIRE(api.activate(device) == STILLGRID_DEVICE_OK);
  api.emergency_stop(device);
  stillgrid_device_state state{};
  state.struct_size = sizeof state;
  REQUIRE(api.read(device, 0, &state) == STILLGRID_DEVICE_OK);
  CHECK(state.position_m[2] == 0.0);
  REQUIRE(api.deactivate(device) == STILLGRID_DEVICE_OK);
  REQUIRE(api.activate(device) == STILLGRID_DEVICE_OK);
  REQUIRE(api.read(device, 0, &state) == STILLGRID_DEVICE_OK);
  CHECK(state.position_m[2] == 1.0);
  api.close(device);
}

TEST_CASE("A stop that comes while motors come on is not lost", "[plugin_support]") {
  static stillgrid_device* device = nullptr;
  const stillgrid_device_api api = negotiated();
  REQUIRE(api.open(0, &device) == STILLGRID_DEVICE_OK);
  while_activating = [] { Adapter::emergency_stop(device); };
  CHECK(api.activate(device) == STILLGRID_DEVICE_OK);
  while_activating = nullptr;
  stillgrid_device_state state{};
  state.struct_size = sizeof state;
  REQUIRE(api.read(device, 0, &state) == STILLGRID_DEVICE_OK);
  CHECK(state.position_m[2] == 0.0);
  api.close(device);
}

}  // namespace
}  // namespace stillgrid::devices::plugin_support_test
