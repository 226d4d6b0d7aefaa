#include "haptic_server/device_life.hpp"

#include <spdlog/spdlog.h>

#include <string>

#include "shared/realtime/stop_signal.hpp"

namespace stillgrid::haptic_server {
namespace {

bool has_motors(const device::Device& device) {
  return (device.descriptor().flags & STILLGRID_DEVICE_NO_MOTORS) == 0;
}

void deactivate(Run& run) {
  if (!run.device.is_active()) return;
  run.watchdog.watch_release();
  const std::int32_t code = run.device.deactivate();
  if (code != STILLGRID_DEVICE_OK) {
    const std::string line = run.device.error_line(code);
    run.device.emergency_stop();
    throw DeviceFault("device '" + run.report.device + "': deactivate: " + line);
  }
  run.guarded.has_motors = false;
}

}  // namespace

void require_no_motors(const device::Device& device, const device::DeviceSpec& spec) {
  if (has_motors(device))
    throw device::DeviceError(
        device::DeviceFailure::kBadInput,
        "device '" + spec.plugin +
            "': --lockstep: expected a device that declares "
            "STILLGRID_DEVICE_NO_MOTORS (simulated, recorded or input alone): in "
            "virtual time nothing watches over a force");
}

void activate(Run& run) {
  run.watchdog.watch_call();
  run.guarded.has_motors = has_motors(run.device);
  try {
    run.device.activate();
    realtime::install_stop_signal();  // a driver's own handlers must not keep a stop from us
    run.watchdog.rest();
  } catch (...) {
    run.device.emergency_stop();
    run.guarded.has_motors = false;  // as the driver says
    throw;
  }
}

void release(Run& run) {
  if (!run.options.lockstep && !run.loop.release()) run.device.emergency_stop();
  deactivate(run);
}

void recover(Run& run) {
  constexpr std::uint64_t kMaxStops = 3;
  const std::uint64_t stops = run.report.device_stops = run.watchdog.stops();
  spdlog::warn("no tick for 100 ms or more: the device was stopped");
  if (stops >= kMaxStops)
    throw DeviceFault("device '" + run.report.device + "': stopped " + std::to_string(stops) +
                      " times for want of ticks; expected calls that return in time");
  deactivate(run);
  activate(run);
  run.loop.cut();
  run.watchdog.watch_ticks();
}

void throw_fault(Run& run) {
  run.device.emergency_stop();
  throw DeviceFault("device '" + run.report.device +
                    "': " + run.device.error_line(run.loop.device_code()));
}

}  // namespace stillgrid::haptic_server
