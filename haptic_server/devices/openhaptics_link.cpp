#include "haptic_server/devices/openhaptics_link.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <vector>

#include "haptic_server/devices/device_profile.hpp"
#include "haptic_server/devices/driver_host.hpp"
#include "haptic_server/devices/vendor_listing.hpp"

namespace stillgrid::devices {
namespace {

/// Names of configurations, in order.
std::vector<std::string> configurations() {
  std::vector<std::string> names;
  const char* const home = std::getenv("GTDD_HOME");
  if (home == nullptr) return names;
  std::error_code error;
  for (const auto& file :
       std::filesystem::directory_iterator(std::filesystem::path(home) / "config", error)) {
    if (file.path().extension() == ".config") names.push_back(file.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

[[noreturn]] void refuse(const OpenHapticsLibrary& hd, const std::string& name, unsigned code) {
  const std::string which = name.empty() ? "the default device" : "the device '" + name + "'";
  const std::string reason = hd.get_error_string(code);
  if (code == kHdDeviceAlreadyInitiated)
    throw DriverError(STILLGRID_DEVICE_E_NO_DEVICE,
                      which + " is busy, another program has it: " + reason);
  throw DriverError(STILLGRID_DEVICE_E_NO_DEVICE,
                    which + " does not open: " + reason +
                        ": is it plugged in, powered and known to the vendor's setup program?");
}

unsigned initialised(const OpenHapticsLibrary& hd, const std::string& name) {
  const unsigned device = hd.init_device(name.empty() ? nullptr : name.c_str());
  const HdError error = hd.take_error();
  if (error.code != kHdSuccess) refuse(hd, name, error.code);
  if (device == kHdInvalidHandle) refuse(hd, name, kHdCommError);
  return device;
}

std::string serial_of(const OpenHapticsLibrary& hd, unsigned device) {
  hd.make_current_device(device);
  return hd.text_of(kHdDeviceSerialNumber);
}

/// The device of that serial number among all configurations.
unsigned of_serial(const OpenHapticsLibrary& hd, const std::string& serial) {
  std::vector<std::string> names = configurations();
  if (names.empty()) names.emplace_back();
  std::string seen;
  for (const std::string& name : names) {
    const unsigned device = hd.init_device(name.empty() ? nullptr : name.c_str());
    if (hd.take_error().code != kHdSuccess || device == kHdInvalidHandle) continue;
    const std::string found = serial_of(hd, device);
    if (found == serial) return device;
    hd.disable_device(device);
    seen += (seen.empty() ? "" : ", ") + found;
  }
  throw DriverError(STILLGRID_DEVICE_E_NO_DEVICE,
                    "no device has serial=" + serial + ": seen: " + (seen.empty() ? "none" : seen));
}

unsigned opened(const OpenHapticsLibrary& hd, const OpenHapticsChoice& choice) {
  const unsigned device =
      choice.serial.empty() ? initialised(hd, choice.name) : of_serial(hd, choice.serial);
  hd.make_current_device(device);
  const std::string version = hd.text_of(kHdVersion);
  if (version.starts_with("3")) return device;
  hd.disable_device(device);
  throw DriverError(STILLGRID_DEVICE_E_NO_DEVICE, hd.library.name() + " is version '" + version +
                                                      "' of OpenHaptics: expected version 3");
}

/// A figure of the vendor's, times scale; zero where it tells none.
double figure(const OpenHapticsLibrary& hd, unsigned parameter, double scale = 1.0) {
  double number = 0.0;
  hd.get_doublev(parameter, &number);
  const bool is_told = hd.take_error().code == kHdSuccess && std::isfinite(number) && number > 0.0;
  return is_told ? number * scale : 0.0;
}

}  // namespace

OpenHapticsLink::OpenHapticsLink(const OpenHapticsChoice& choice)
    : hd(choice.library),
      device(opened(hd, choice)),
      model(hd.text_of(kHdDeviceModelType)),
      serial(hd.text_of(kHdDeviceSerialNumber)),
      firmware(hd.text_of(kHdDeviceFirmwareVersion)),
      version(hd.text_of(kHdVersion)) {
  (void)hd.take_error();
}

void OpenHapticsLink::describe(stillgrid_device_descriptor& descriptor) const {
  constexpr std::uint32_t kPosition = STILLGRID_DOF_X | STILLGRID_DOF_Y | STILLGRID_DOF_Z;
  hd.make_current_device(device);
  copy_text(descriptor.name, model.empty() ? "OpenHaptics" : model);
  descriptor.max_force_N = figure(hd, kHdNominalMaxForce);
  descriptor.continuous_force_N = figure(hd, kHdNominalMaxContinuousForce);
  descriptor.nominal_stiffness_N_per_m = figure(hd, kHdNominalMaxStiffness, 1e3);
  std::array<double, 6> corners_mm{};
  hd.get_doublev(kHdMaxWorkspaceDimensions, corners_mm.data());
  const bool has_corners = hd.take_error().code == kHdSuccess &&
                           std::all_of(corners_mm.begin(), corners_mm.end(),
                                       [](double mm) { return std::isfinite(mm); });
  for (std::size_t axis = 0; has_corners && axis < 3; ++axis) {
    if (corners_mm[axis] >= corners_mm[axis + 3]) continue;
    descriptor.workspace_min_m[axis] = 1e-3 * corners_mm[axis];
    descriptor.workspace_max_m[axis] = 1e-3 * corners_mm[axis + 3];
  }
  descriptor.dof_sensed =
      kPosition | STILLGRID_DOF_ABOUT_X | STILLGRID_DOF_ABOUT_Y | STILLGRID_DOF_ABOUT_Z;
  descriptor.dof_actuated = kPosition;
  descriptor.button_count = 4;
  if (const auto* const profile = profile_of(openhaptics_profiles(), model))
    fill_in(descriptor, *profile);
}

std::string OpenHapticsLink::calibrate(bool at_reset) const {
  hd.make_current_device(device);
  int styles = 0;
  hd.get_integerv(kHdCalibrationStyle, &styles);
  const unsigned status = hd.check_calibration();
  const int alone = (styles & kHdCalibrationAuto) != 0 ? kHdCalibrationAuto : kHdCalibrationInkwell;
  if (at_reset && (styles & kHdCalibrationEncoderReset) != 0)
    hd.update_calibration(kHdCalibrationEncoderReset);
  else if (status == kHdCalibrationNeedsUpdate && (styles & alone) != 0)
    hd.update_calibration(static_cast<unsigned>(alone));
  const unsigned error = hd.take_error().code;
  if (error != kHdSuccess) return std::string("calibration: ") + hd.get_error_string(error);
  if (hd.check_calibration() == kHdCalibrationOk) return "";
  return (styles & kHdCalibrationEncoderReset) != 0
             ? "not calibrated, so without force: hold the arm in its reset position, then order "
               "calibrate=1"
             : "not calibrated, so without force: put the stylus into its inkwell, then order "
               "calibrate=1";
}

bool list_openhaptics(const std::string& library, std::uint32_t index,
                      stillgrid_device_listing& listing) {
  const OpenHapticsLibrary hd(library);
  std::vector<std::string> names = configurations();
  if (names.empty()) names.emplace_back();
  if (index >= names.size()) return false;
  const std::string& name = names[index];
  const unsigned device = hd.init_device(name.empty() ? nullptr : name.c_str());
  const HdError error = hd.take_error();
  const bool is_there = error.code == kHdSuccess && device != kHdInvalidHandle;
  if (!is_there && name.empty()) return false;  // nothing is known to be there
  if (!is_there) {
    fill_listing(listing, std::string(hd.get_error_string(error.code)), "", "name=" + name,
                 library);
    return true;
  }
  const std::string serial = serial_of(hd, device);
  fill_listing(listing, hd.text_of(kHdDeviceModelType), serial,
               name.empty() ? "serial=" + serial : "name=" + name, library);
  hd.disable_device(device);
  return true;
}

}  // namespace stillgrid::devices
