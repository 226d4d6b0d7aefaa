#include "haptic_server/devices/force_dimension_link.hpp"

#include "haptic_server/devices/device_profile.hpp"
#include "haptic_server/devices/driver_host.hpp"
#include "haptic_server/devices/vendor_listing.hpp"

namespace stillgrid::devices {
namespace {

constexpr int kBusyController = 3, kDeviceInUse = 20;  // of dhdErrorGetLast()

std::string words_of(const ForceDimensionChoice& choice) {
  if (choice.serial) return "the device with serial=" + std::to_string(*choice.serial);
  if (choice.index) return "the device with index=" + std::to_string(*choice.index);
  return "a device";
}

char opened(const ForceDimensionLibrary& dhd, const ForceDimensionChoice& choice) {
  const int count = dhd.get_device_count();
  if (count < 0) {
    throw DriverError(STILLGRID_DEVICE_E_IO,
                      "the vendor's library cannot look for devices: " + dhd.last_error());
  }
  if (count == 0)
    throw DriverError(STILLGRID_DEVICE_E_NO_DEVICE,
                      "no device is connected, or it may not be used (docs/first_ten_minutes.md)");
  const int id = choice.serial  ? dhd.open_serial(*choice.serial)
                 : choice.index ? dhd.open_id(static_cast<char>(*choice.index))
                                : dhd.open();
  if (id >= 0) return static_cast<char>(id);
  const int error = dhd.error_get_last();
  const std::string reason = dhd.error_get_str(error);
  if (error == kDeviceInUse || error == kBusyController)
    throw DriverError(STILLGRID_DEVICE_E_NO_DEVICE,
                      words_of(choice) + " is busy, another program has it: " + reason);
  throw DriverError(
      STILLGRID_DEVICE_E_NO_DEVICE,
      words_of(choice) + " does not open, of " + std::to_string(count) + " connected: " + reason);
}

std::string name_of(const ForceDimensionLibrary& dhd, char id) {
  const char* const name = dhd.get_system_name(id);
  return name == nullptr ? "Force Dimension" : name;
}

std::string serial_of(const ForceDimensionLibrary& dhd, char id) {
  unsigned short serial = 0;
  return dhd.get_serial_number(&serial, id) < 0 ? "" : std::to_string(serial);
}

}  // namespace

ForceDimensionLink::ForceDimensionLink(const ForceDimensionChoice& choice)
    : dhd(choice.library),
      id(opened(dhd, choice)),
      name(name_of(dhd, id)),
      serial(serial_of(dhd, id)),
      has_wrist(dhd.has_wrist(id)),
      has_active_wrist(dhd.has_active_wrist(id)),
      has_gripper(dhd.has_gripper(id)),
      has_active_gripper(dhd.has_active_gripper(id)) {}

void ForceDimensionLink::describe(stillgrid_device_descriptor& descriptor) const {
  constexpr std::uint32_t kBase = STILLGRID_DOF_X | STILLGRID_DOF_Y | STILLGRID_DOF_Z;
  constexpr std::uint32_t kWrist =
      STILLGRID_DOF_ABOUT_X | STILLGRID_DOF_ABOUT_Y | STILLGRID_DOF_ABOUT_Z;
  descriptor.dof_sensed =
      kBase | (has_wrist ? kWrist : 0U) | (has_gripper ? STILLGRID_DOF_GRIPPER : 0U);
  descriptor.dof_actuated =
      kBase | (has_active_wrist ? kWrist : 0U) | (has_active_gripper ? STILLGRID_DOF_GRIPPER : 0U);
  copy_text(descriptor.name, name);
  const DeviceProfile* const profile = profile_of(force_dimension_profiles(), name);
  if (profile != nullptr) fill_in(descriptor, *profile);
}

void ForceDimensionLink::require(int result, const char* what) const {
  if (result < 0)
    throw DriverError(STILLGRID_DEVICE_E_IO, std::string(what) + ": " + dhd.last_error());
}

bool list_force_dimension(const std::string& library, std::uint32_t index,
                          stillgrid_device_listing& listing) {
  const ForceDimensionLibrary dhd(library);
  const int count = dhd.get_device_count();
  if (count < 0 || index >= static_cast<std::uint32_t>(count)) return false;
  const std::string by_index = "index=" + std::to_string(index);
  const int id = dhd.open_id(static_cast<char>(index));
  if (id < 0) {
    fill_listing(listing, "in use: " + dhd.last_error(), "", by_index, library);
    return true;
  }
  const auto device = static_cast<char>(id);
  const std::string serial = serial_of(dhd, device);
  fill_listing(listing, name_of(dhd, device), serial,
               serial.empty() ? by_index : "serial=" + serial, library);
  dhd.close(device);
  return true;
}

}  // namespace stillgrid::devices
