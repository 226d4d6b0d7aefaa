#pragma once

#include "haptic_server/device/device_host.hpp"
#include "haptic_server/device/device_spec.hpp"

namespace stillgrid {

/// Takes away the force that another process, ended since, left on a device: opens it anew and
/// leaves it at zero force with its motors off, by emergency_stop, activate and deactivate. An
/// emergency_stop that has not returned after 100 ms is not waited for.
///
/// For a process that does nothing else: a driver may crash, hang or end it. Throws DeviceError.
void release_by_activation(const DeviceSpec& spec, const DeviceLoop& loop);

/// The same by open and emergency_stop alone, for where a driver's activate or deactivate fails.
void release_by_stop(const DeviceSpec& spec, const DeviceLoop& loop);

}  // namespace stillgrid
