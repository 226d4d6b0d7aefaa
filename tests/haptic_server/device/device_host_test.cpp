#include "haptic_server/device/device_host.hpp"

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <catch2/catch.hpp>
#include <memory>
#include <sstream>
#include <string>

#include "tests/haptic_server/devices/recording_file.hpp"

namespace stillgrid::device::device_host_test {
namespace {

const Eigen::Vector3d kNoTorque_N_m = Eigen::Vector3d::Zero();

constexpr std::uint64_t kTick_ns = 1'000'000;
const DeviceLoop kLockstep{kTick_ns, true};
const std::string kPhantom = STILLGRID_PLUGIN_DIR "/phantom.so";
const std::string kReplay = STILLGRID_PLUGIN_DIR "/replay.so";

struct Failure {
  int exit_status = 0;
  std::string line;
};

Failure failure_of(const std::string& device) {
  try {
    Device opened(parse_device_spec(device), kLockstep);
    opened.activate();
  } catch (const DeviceError& error) {
    return {error.exit_status(), error.what()};
  }
  return {};
}

TEST_CASE("A device is opened, described, read and written", "[device_host]") {
  Device device(parse_device_spec(kPhantom + ":profile=touchx,hand=measured,path=tap"), kLockstep);
  device.activate();
  CHECK(device.descriptor().max_force_N == 7.9);
  CHECK(std::string(device.descriptor().name) == "phantom");
  stillgrid_device_state state{};
  for (std::uint64_t n = 0; n < 100; ++n) {
    REQUIRE(device.read(n * kTick_ns, state) == STILLGRID_DEVICE_OK);
    REQUIRE(device.write(n * kTick_ns, {0.0, 0.0, 0.1}, kNoTorque_N_m) == STILLGRID_DEVICE_OK);
  }
  CHECK(state.sequence == 100);
  CHECK(state.time_ns == 99 * kTick_ns);
}

TEST_CASE("The same device gives the same bits twice", "[device_host]") {
  const DeviceSpec spec = parse_device_spec(kPhantom + ":path=circle,noise_m=1e-5,seed=7");
  Device one(spec, kLockstep);
  one.activate();
  Device two(spec, kLockstep);
  two.activate();
  stillgrid_device_state first{};
  stillgrid_device_state second{};
  for (std::uint64_t n = 0; n < 1000; ++n) {
    REQUIRE(one.read(n * kTick_ns, first) == STILLGRID_DEVICE_OK);
    REQUIRE(two.read(n * kTick_ns, second) == STILLGRID_DEVICE_OK);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      REQUIRE(first.position_m[axis] == second.position_m[axis]);
    }
    const Eigen::Vector3d force_N(0.0, 0.0, -20.0 * first.position_m[2]);
    REQUIRE(one.write(n * kTick_ns, force_N, kNoTorque_N_m) == STILLGRID_DEVICE_OK);
    REQUIRE(two.write(n * kTick_ns, force_N, kNoTorque_N_m) == STILLGRID_DEVICE_OK);
  }
}

TEST_CASE("The end of a recording is told apart from a fault", "[device_host]") {
  const devices::RecordingFile file("t_s,x_m,y_m,z_m\n0,1,2,3\n0.001,2,2,3\n");
  Device device(parse_device_spec(kReplay + ":file=" + file.path()), kLockstep);
  device.activate();
  stillgrid_device_state state{};
  CHECK(device.read(0, state) == STILLGRID_DEVICE_OK);
  CHECK(device.read(2 * kTick_ns, state) == STILLGRID_DEVICE_END);
  CHECK(state.valid == STILLGRID_STATE_POSITION);
  CHECK(device.error_line(STILLGRID_DEVICE_END).find("end") != std::string::npos);
}

TEST_CASE("A device that is open has its motors off until it is activated", "[device_host]") {
  Device device(parse_device_spec(kPhantom), kLockstep);
  stillgrid_device_state state{};
  CHECK(device.read(0, state) == STILLGRID_DEVICE_E_ORDER);
  device.activate();
  CHECK(device.read(0, state) == STILLGRID_DEVICE_OK);
}

TEST_CASE("A deactivated device is neither read nor written", "[device_host]") {
  Device device(parse_device_spec(kPhantom), kLockstep);
  device.activate();
  device.emergency_stop();
  device.deactivate();
  device.deactivate();
  stillgrid_device_state state{};
  CHECK(device.read(0, state) == STILLGRID_DEVICE_E_ORDER);
  CHECK(state.valid == 0);
  CHECK(device.write(0, {0.0, 0.0, 0.0}, kNoTorque_N_m) == STILLGRID_DEVICE_E_ORDER);
}

TEST_CASE("A missing plugin or a bad option is bad input, named in one line", "[device_host]") {
  CHECK(failure_of("/nowhere/none.so").exit_status == 1);
  CHECK(failure_of(STILLGRID_SOURCE_DIR "/proto/device_plugin.h").exit_status == 1);

  const Failure hand = failure_of(kPhantom + ":hand=heavy");
  CHECK(hand.exit_status == 1);
  CHECK(hand.line == "device '" + kPhantom +
                         "': option hand=heavy: hand: value 'heavy': expected none, light or "
                         "measured");
  const Failure file = failure_of(kReplay);
  CHECK(file.exit_status == 1);
  CHECK(file.line.find("file=PATH is required") != std::string::npos);
  CHECK(failure_of(kReplay + ":file=/nowhere/none.csv").exit_status == 1);
}

TEST_CASE("A driver of another version cannot start", "[device_host]") {
  const Failure failure = failure_of(STILLGRID_BAD_DRIVER_DIR "/another_version.so");
  CHECK(failure.exit_status == 2);
  CHECK(failure.line.find("built for another version of the device interface: expected 2") !=
        std::string::npos);
}

TEST_CASE("A device that does not open is a fault, in the driver's words", "[device_host]") {
  const Failure failure = failure_of(STILLGRID_BAD_DRIVER_DIR "/fails_to_open.so");
  CHECK(failure.exit_status == 3);
  CHECK(failure.line.find("open: the cable is not plugged in") != std::string::npos);
}

TEST_CASE("A driver that throws is a fault that takes nobody along", "[device_host]") {
  const std::string driver = STILLGRID_BAD_DRIVER_DIR "/throws.so";
  CHECK(failure_of(driver).exit_status == 3);

  Device device(parse_device_spec(driver + ":be=calm"), kLockstep);
  device.activate();
  stillgrid_device_state state{};
  CHECK(device.read(0, state) == STILLGRID_DEVICE_E_IO);
  CHECK(state.valid == 0);
  CHECK(device.write(0, {0.0, 0.0, 0.0}, kNoTorque_N_m) == STILLGRID_DEVICE_E_IO);
  device.emergency_stop();
  CHECK(device.error_line(STILLGRID_DEVICE_E_IO) == "code -5");
}

const std::string kOversteps = STILLGRID_BAD_DRIVER_DIR "/oversteps.so";

TEST_CASE("A driver that writes past a struct is a fault, named with the call", "[device_host]") {
  for (const std::string call : {"describe", "identify"}) {
    const Failure failure = failure_of(kOversteps + ":past=" + call);
    CHECK(failure.exit_status == 3);
    CHECK(failure.line.find(call + ": wrote past the struct_size") != std::string::npos);
  }
  Device device(parse_device_spec(kOversteps + ":past=read"), kLockstep);
  device.activate();
  stillgrid_device_state state{};
  CHECK(device.read(0, state) == STILLGRID_DEVICE_E_IO);
  CHECK(state.valid == 0);
}

TEST_CASE("The host's sizes stay what they are, whatever a driver says", "[device_host]") {
  Device device(parse_device_spec(kOversteps), kLockstep);
  device.activate();
  CHECK(device.descriptor().struct_size == sizeof(stillgrid_device_descriptor));
  stillgrid_device_state state{};
  CHECK(device.read(0, state) == STILLGRID_DEVICE_OK);
  CHECK(state.struct_size == sizeof state);
}

TEST_CASE("What a driver calls its device is one line of UTF-8 that ends", "[device_host]") {
  const Device device(parse_device_spec(kOversteps), kLockstep);
  const std::string name = device.descriptor().name;
  CHECK(name == "two lines" + std::string(STILLGRID_DEVICE_NAME_SIZE - 1 - 9, 'x'));
  CHECK(device.identity().serial == std::string(STILLGRID_IDENTITY_SIZE - 1, '?'));
  CHECK(device.identity().firmware == "M\xC3\xBChle \xE2\x82\xAC 7");
  CHECK(device.identity().driver.empty());
}

TEST_CASE("What a driver logs is a line under its plugin's name", "[device_host]") {
  std::ostringstream text;
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(std::make_shared<spdlog::logger>(
      "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(text)));
  spdlog::set_pattern("%l %v");
  Device(parse_device_spec(kOversteps), kLockstep).activate();
  spdlog::set_default_logger(before);
  CHECK(text.str() == "warning device '" + kOversteps + "': motors on\n");
}

}  // namespace
}  // namespace stillgrid::device::device_host_test
