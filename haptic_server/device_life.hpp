#pragma once

#include "haptic_server/device/device_host.hpp"
#include "haptic_server/device/device_spec.hpp"
#include "haptic_server/run.hpp"

namespace stillgrid::haptic_server {

class RealTimeTicks;

/// What a run asks of its device outside of ticks. Each call is watched, and the guardian is told
/// of motors that are on. Thread: the loop's; not in a tick.

/// Virtual time stands still for as long as the simulation takes, and a force with it. Throws
/// DeviceError for a device that may have motors.
void require_no_motors(const device::Device& device, const device::DeviceSpec& spec);

/// A force asked for that nothing exerts. Throws DeviceError.
void require_gripper(const device::Device& device, const device::DeviceSpec& spec);

/// Motors on, zero force. Throws DeviceError; the motors are off then.
void activate(Run& run);

/// Motors off; nothing for a device that is not active. A force that no tick could fade is cut.
/// Throws DeviceFault where the driver failed: its device was told an emergency stop then, and the
/// guardian will release it.
void release(Run& run);

/// Motors off, and the last tick of a device that sets the pace is over. Throws DeviceFault.
void deactivate(Run& run);

/// The watchdog has stopped the device: counts it, a line each. Throws DeviceFault at the third.
void count_stop(Run& run);

/// The device no longer answers: closes it and opens it again, a second apart, as often as the
/// options allow in the whole run, until it is active, no force on its way. False where the run is
/// stopped meanwhile. Throws DeviceFault where it does not come back, or another comes in its
/// place.
[[nodiscard]] bool reopen(Run& run, RealTimeTicks& ticks);

/// Zero force, and the driver's line on the code of its last call.
[[noreturn]] void throw_fault(Run& run);

}  // namespace stillgrid::haptic_server
