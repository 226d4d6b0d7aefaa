#include "haptic_server/device_life.hpp"

#include <spdlog/spdlog.h>

#include <chrono>
#include <string>
#include <thread>

#include "haptic_server/real_time_ticks.hpp"
#include "shared/realtime/stop_signal.hpp"

namespace stillgrid::haptic_server {
namespace {

bool has_motors(const device::Device& device) {
  return (device.descriptor().flags & STILLGRID_DEVICE_NO_MOTORS) == 0;
}

/// Whatever it answers: it is about to be closed.
void leave(Run& run) {
  run.device.emergency_stop();
  try {
    deactivate(run);
  } catch (const DeviceFault&) {  // NOLINT(bugprone-empty-catch): that it fails is known
  }
  run.watchdog.rest();
  while (run.watchdog.is_stopping()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
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

void require_gripper(const device::Device& device, const device::DeviceSpec& spec) {
  const stillgrid_device_descriptor& is = device.descriptor();
  const bool exerts = is.dof_actuated == 0 || (is.dof_actuated & STILLGRID_DOF_GRIPPER) != 0;
  if (is.max_gripper_force_N == 0.0 || is.gripper_open_m == 0.0 || !exerts)
    throw device::DeviceError(
        device::DeviceFailure::kBadInput,
        "device '" + spec.plugin +
            "': --gripper-stiffness: expected a device that declares a gripper "
            "with a motor, and how far it opens");
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

void release(Run& run) {
  if (!run.options.lockstep && !run.loop.release()) run.device.emergency_stop();
  deactivate(run);
}

void count_stop(Run& run) {
  constexpr std::uint64_t kMaxStops = 3;
  const std::uint64_t stops = run.report.device_stops = run.watchdog.stops();
  spdlog::warn("no tick for 100 ms or more: the device was stopped");
  if (stops >= kMaxStops)
    throw DeviceFault("device '" + run.report.device + "': stopped " + std::to_string(stops) +
                      " times for want of ticks; expected calls that return in time");
}

bool reopen(Run& run, RealTimeTicks& ticks) {
  constexpr std::chrono::milliseconds kBetween{1000}, kPoll{50};
  const std::string lost =
      "device '" + run.report.device + "': " + run.device.error_line(run.loop.device_code());
  leave(run);
  if (const auto tries = run.options.reopenings - run.report.reopenings; tries > 0)
    spdlog::warn("{}; no force; it is opened again up to {} times", lost, tries);
  const auto is_over = [&] { return run.stop || ticks.is_past_end(); };
  while (run.report.reopenings < run.options.reopenings) {
    for (std::chrono::milliseconds waited{0}; waited < kBetween && !is_over(); waited += kPoll)
      std::this_thread::sleep_for(kPoll);
    if (is_over()) return false;
    ++run.report.reopenings;
    try {
      run.watchdog.watch_call();
      run.device.reopen();
      run.loop.begin_anew();
      ticks.resume();
      activate(run);
      spdlog::info("device '{}': open again, at try {} of {}", run.report.device,
                   run.report.reopenings, run.options.reopenings);
      return true;
    } catch (const device::DeviceError& error) {
      run.watchdog.rest();
      spdlog::warn("{}", error.what());
    }
  }
  throw DeviceFault(lost + "; no further try of " + std::to_string(run.options.reopenings));
}

void throw_fault(Run& run) {
  run.device.emergency_stop();
  throw DeviceFault("device '" + run.report.device +
                    "': " + run.device.error_line(run.loop.device_code()));
}

}  // namespace stillgrid::haptic_server
