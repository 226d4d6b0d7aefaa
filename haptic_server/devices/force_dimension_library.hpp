#pragma once

#include <cstdint>
#include <string>

#include "haptic_server/devices/vendor_library.hpp"

namespace stillgrid::devices {

/// What we use of Force Dimension's haptic SDK, version 3: its functions by their published names,
/// types and meanings. A device's number is what an open function returned; functions return a
/// negative number on failure. Metres, newtons; x is depth, y across, z up.
struct ForceDimensionLibrary {
  /// Throws one line: no library, a function missing, another version.
  explicit ForceDimensionLibrary(const std::string& path);

  VendorLibrary library;
  std::string version;

  void (*get_sdk_version)(int*, int*, int*, int*) = nullptr;
  int (*error_get_last)() = nullptr;  // of the calling thread
  const char* (*error_get_str)(int) = nullptr;
  int (*get_device_count)() = nullptr;
  int (*open)() = nullptr;  // the first that nobody has
  int (*open_id)(char) = nullptr;
  int (*open_serial)(int) = nullptr;
  int (*close)(char) = nullptr;
  int (*get_serial_number)(unsigned short*, char) = nullptr;
  const char* (*get_system_name)(char) = nullptr;
  int (*get_status)(int*, char) = nullptr;
  bool (*has_wrist)(char) = nullptr;
  bool (*has_active_wrist)(char) = nullptr;
  bool (*has_gripper)(char) = nullptr;
  bool (*has_active_gripper)(char) = nullptr;
  int (*stop)(char) = nullptr;  // force off, brakes on
  int (*enable_force)(unsigned char, char) = nullptr;
  int (*set_brakes)(int, char) = nullptr;
  int (*set_gravity_compensation)(int, char) = nullptr;
  int (*get_position)(double*, double*, double*, char) = nullptr;
  int (*get_orientation_frame)(double (*)[3], char) = nullptr;
  int (*get_linear_velocity)(double*, double*, double*, char) = nullptr;
  int (*get_gripper_gap)(double*, char) = nullptr;
  std::uint32_t (*get_button_mask)(char) = nullptr;
  int (*set_force_and_torque_and_gripper_force)(double, double, double, double, double, double,
                                                double, char) = nullptr;
  // Not in every version, and not for every device.
  int (*enable_expert_mode)() = nullptr;
  int (*disable_expert_mode)() = nullptr;
  int (*set_watchdog)(unsigned char, char) = nullptr;  // in steps of 125 us, 0: none

  /// What the last failure in this thread was, in the vendor's words.
  [[nodiscard]] std::string last_error() const { return error_get_str(error_get_last()); }
};

}  // namespace stillgrid::devices
