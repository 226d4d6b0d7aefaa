#pragma once

#include <string>

#include "haptic_server/device/device_spec.hpp"

namespace stillgrid::device {

/// Prints a line for each device that a plugin sees with these options: what to give --device, its
/// name and its serial number; or why there is none. A driver without a list of its own is asked
/// what each of the devices that it enumerates is, motors off. Not beside a device that is in use.
void print_devices(const DeviceSpec& spec);

/// The same for each plugin that find_device_plugin() finds by its name, in a process each: one
/// that crashes or takes longer than 20 s is a line too. Before any thread starts.
void print_installed_devices();

}  // namespace stillgrid::device
