#pragma once

#include "haptic_server/device/device_host.hpp"
#include "haptic_server/device/device_spec.hpp"

namespace stillgrid::device {

/// What is called on a device once it is open; a driver that cannot bear one of these calls may
/// bear the others. Each leaves zero force by the contract of drivers.
enum class ReleaseWay {
  kEveryCall,  // emergency_stop, waited for no longer than 100 ms, activate, deactivate
  kStopAlone,
  kWithoutStop,  // activate, deactivate
};

/// Takes away the force that another process, ended since, left on a device: opens it anew and
/// leaves it at zero force with its motors off.
///
/// For a process that does nothing else: a driver may crash, hang or end it. Throws DeviceError.
void release_device(const DeviceSpec& spec, const DeviceLoop& loop, ReleaseWay way);

}  // namespace stillgrid::device
