#include "haptic_server/device/device_host.hpp"

#include <catch2/catch.hpp>
#include <string>

#include "tests/haptic_server/devices/recording_file.hpp"

namespace stillgrid {
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
    const Device opened(parse_device_spec(device), kLockstep);
  } catch (const DeviceError& error) {
    return {error.exit_status(), error.what()};
  }
  return {};
}

TEST_CASE("A device is opened, described, read and written", "[device_host]") {
  Device device(parse_device_spec(kPhantom + ":profile=touchx,hand=measured,path=tap"), kLockstep);
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
  Device two(spec, kLockstep);
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
  const RecordingFile file("t_s,x_m,y_m,z_m\n0,1,2,3\n0.001,2,2,3\n");
  Device device(parse_device_spec(kReplay + ":file=" + file.path()), kLockstep);
  stillgrid_device_state state{};
  CHECK(device.read(0, state) == STILLGRID_DEVICE_OK);
  CHECK(device.read(2 * kTick_ns, state) == STILLGRID_DEVICE_END);
  CHECK(state.valid == STILLGRID_STATE_POSITION);
  CHECK(device.error_line(STILLGRID_DEVICE_END).find("end") != std::string::npos);
}

TEST_CASE("A deactivated device is neither read nor written", "[device_host]") {
  Device device(parse_device_spec(kPhantom), kLockstep);
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
  const Failure failure = failure_of(STILLGRID_BAD_DRIVER_DIR "/no_common_version.so");
  CHECK(failure.exit_status == 2);
  CHECK(failure.line.find("no common version") != std::string::npos);
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
  stillgrid_device_state state{};
  CHECK(device.read(0, state) == STILLGRID_DEVICE_E_IO);
  CHECK(state.valid == 0);
  CHECK(device.write(0, {0.0, 0.0, 0.0}, kNoTorque_N_m) == STILLGRID_DEVICE_E_IO);
  device.emergency_stop();
  CHECK(device.error_line(STILLGRID_DEVICE_E_IO) == "code -5");
}

}  // namespace
}  // namespace stillgrid
