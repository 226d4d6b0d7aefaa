#pragma once

#include <string>

#include "haptic_server/devices/vendor_library.hpp"

namespace stillgrid::devices {

/// An error as hdGetError() returns it.
struct HdError {
  unsigned code;
  int internal_code;
  unsigned device;
};

/// Numbers of OpenHaptics' HD API, as published.
enum HdNumber : unsigned {
  kHdSuccess = 0,
  kHdDeviceAlreadyInitiated = 0x0301,
  kHdCommError = 0x0302,
  kHdInvalidHandle = 0xFFFFFFFF,

  kHdCurrentButtons = 0x2000,
  kHdCurrentPosition = 0x2050,   // mm
  kHdCurrentVelocity = 0x2051,   // mm/s
  kHdCurrentTransform = 0x2052,  // 4 by 4, column by column, mm
  kHdVersion = 0x2500,
  kHdDeviceModelType = 0x2501,
  kHdDeviceSerialNumber = 0x2504,
  kHdDeviceFirmwareVersion = 0x2505,
  kHdMaxWorkspaceDimensions = 0x2550,  // mm: least x, y, z, greatest x, y, z
  kHdInputDof = 0x2553,
  kHdCalibrationStyle = 0x2555,
  kHdNominalMaxStiffness = 0x2602,  // N/mm
  kHdNominalMaxForce = 0x2603,
  kHdNominalMaxContinuousForce = 0x2604,
  kHdMotorTemperature = 0x2605,  // predicted, up to six; from 1 on a motor is warm
  kHdCurrentForce = 0x2700,
  kHdForceOutput = 0x4000,

  kHdCalibrationOk = 0x5000,
  kHdCalibrationNeedsUpdate = 0x5001,

  kHdCallbackDone = 0,
  kHdCallbackContinue = 1,
  kHdMaxSchedulerPriority = 65535,
};

/// Styles of calibration, bits.
constexpr int kHdCalibrationEncoderReset = 1, kHdCalibrationAuto = 2, kHdCalibrationInkwell = 4;

using HdCallback = unsigned (*)(void*);

/// What we use of OpenHaptics' HD API, version 3: its functions by their published names, types and
/// meanings. State and force pass between begin_frame() and end_frame(), in the scheduler's thread.
/// Failures are taken from a stack by get_error(). Millimetres, newtons; x to the right, y up, z
/// towards the user.
struct OpenHapticsLibrary {
  /// Throws one line: no library, a function missing.
  explicit OpenHapticsLibrary(const std::string& path);

  VendorLibrary library;

  unsigned (*init_device)(const char*) = nullptr;  // a configuration's name, or null
  void (*disable_device)(unsigned) = nullptr;
  void (*make_current_device)(unsigned) = nullptr;
  void (*begin_frame)(unsigned) = nullptr;
  void (*end_frame)(unsigned) = nullptr;
  HdError (*get_error)() = nullptr;
  const char* (*get_error_string)(unsigned) = nullptr;
  void (*enable)(unsigned) = nullptr;
  void (*disable)(unsigned) = nullptr;
  unsigned char (*is_enabled)(unsigned) = nullptr;
  void (*get_integerv)(unsigned, int*) = nullptr;
  void (*get_doublev)(unsigned, double*) = nullptr;
  const char* (*get_string)(unsigned) = nullptr;
  void (*set_doublev)(unsigned, const double*) = nullptr;
  unsigned (*check_calibration)() = nullptr;
  void (*update_calibration)(unsigned) = nullptr;
  void (*start_scheduler)() = nullptr;
  void (*stop_scheduler)() = nullptr;
  void (*set_scheduler_rate)(unsigned long) = nullptr;  // Hz
  unsigned long (*schedule_asynchronous)(HdCallback, void*, unsigned short) = nullptr;
  void (*unschedule)(unsigned long) = nullptr;

  /// The newest failure, of which there is none left afterwards.
  [[nodiscard]] HdError take_error() const noexcept;
  [[nodiscard]] std::string text_of(unsigned parameter) const;
};

}  // namespace stillgrid::devices
