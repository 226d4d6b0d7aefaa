#include "haptic_server/devices/force_dimension_library.hpp"

#include "haptic_server/devices/driver_host.hpp"

namespace stillgrid::devices {
namespace {

constexpr int kMajor = 3;

void bind_all(ForceDimensionLibrary& dhd) {
  const VendorLibrary& library = dhd.library;
  library.bind(dhd.error_get_last, "dhdErrorGetLast");
  library.bind(dhd.error_get_str, "dhdErrorGetStr");
  library.bind(dhd.get_device_count, "dhdGetDeviceCount");
  library.bind(dhd.open, "dhdOpen");
  library.bind(dhd.open_id, "dhdOpenID");
  library.bind(dhd.open_serial, "dhdOpenSerial");
  library.bind(dhd.close, "dhdClose");
  library.bind(dhd.get_serial_number, "dhdGetSerialNumber");
  library.bind(dhd.get_system_name, "dhdGetSystemName");
  library.bind(dhd.get_status, "dhdGetStatus");
  library.bind(dhd.has_wrist, "dhdHasWrist");
  library.bind(dhd.has_active_wrist, "dhdHasActiveWrist");
  library.bind(dhd.has_gripper, "dhdHasGripper");
  library.bind(dhd.has_active_gripper, "dhdHasActiveGripper");
  library.bind(dhd.stop, "dhdStop");
  library.bind(dhd.enable_force, "dhdEnableForce");
  library.bind(dhd.set_brakes, "dhdSetBrakes");
  library.bind(dhd.set_gravity_compensation, "dhdSetGravityCompensation");
  library.bind(dhd.get_position, "dhdGetPosition");
  library.bind(dhd.get_orientation_frame, "dhdGetOrientationFrame");
  library.bind(dhd.get_linear_velocity, "dhdGetLinearVelocity");
  library.bind(dhd.get_gripper_gap, "dhdGetGripperGap");
  library.bind(dhd.get_button_mask, "dhdGetButtonMask");
  library.bind(dhd.set_force_and_torque_and_gripper_force, "dhdSetForceAndTorqueAndGripperForce");
  library.bind_if_there(dhd.enable_expert_mode, "dhdEnableExpertMode");
  library.bind_if_there(dhd.disable_expert_mode, "dhdDisableExpertMode");
  library.bind_if_there(dhd.set_watchdog, "dhdSetWatchdog");
}

}  // namespace

ForceDimensionLibrary::ForceDimensionLibrary(const std::string& path)
    : library(path, {"libdhd.so.3", "libdhd.so", "libdrd.so.3", "libdrd.so"}) {
  library.bind(get_sdk_version, "dhdGetSDKVersion");
  int major = 0, minor = 0, release = 0, revision = 0;
  get_sdk_version(&major, &minor, &release, &revision);
  version = std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(release);
  if (major != kMajor) {
    throw DriverError(STILLGRID_DEVICE_E_NO_DEVICE, library.name() + " is version " + version +
                                                        " of the SDK: expected version 3");
  }
  bind_all(*this);
}

}  // namespace stillgrid::devices
