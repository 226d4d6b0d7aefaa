#pragma once

#include "haptic_server/device/device_host.hpp"
#include "haptic_server/device/device_spec.hpp"
#include "haptic_server/run.hpp"

namespace stillgrid::haptic_server {

/// What a run asks of its device outside of ticks. Each call is watched, and the guardian is told
/// of motors that are on. Thread: the loop's; not in a tick.

/// Virtual time stands still for as long as the simulation takes, and a force with it. Throws
/// DeviceError for a device that may have motors.
void require_no_motors(const device::Device& device, const device::DeviceSpec& spec);

/// Motors on, zero force. Throws DeviceError; the motors are off then.
void activate(Run& run);

/// Motors off; nothing for a device that is not active. A force that no tick could fade is cut.
/// Throws DeviceFault where the driver failed: its device was told an emergency stop then, and the
/// guardian will release it.
void release(Run& run);

/// The watchdog has stopped the device, and the loop is back: no force, then a ramp. Not for ever:
/// throws DeviceFault at the third time.
void recover(Run& run);

/// Zero force, and the driver's line on the code of its last call.
[[noreturn]] void throw_fault(Run& run);

}  // namespace stillgrid::haptic_server
