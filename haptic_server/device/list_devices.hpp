#pragma once

#include <string>

#include "haptic_server/device/device_spec.hpp"

namespace stillgrid::device {

/// Prints a line for each device that a plugin sees with these options: what to give --device, its
/// name and its serial number; or why there is none. A driver without a list of its own is asked
/// what each of the devices that it enumerates is, motors off. Not beside a device that is in use.
/// In a process of its own: one that crashes, ends the program or takes longer than 20 s is a line
/// too. Returns the exit status: what cannot be listed is one line on standard error. Before any
/// thread starts. Throws DeviceError at a text that is no device.
[[nodiscard]] int print_devices(const std::string& device);

/// The same for each plugin that find_device_plugin() finds by its name; why one has none is in its
/// row. Zero, unless standard output takes no more.
[[nodiscard]] int print_installed_devices();

}  // namespace stillgrid::device
