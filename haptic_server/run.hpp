#pragma once

#include <atomic>
#include <cstdint>

#include "haptic_server/device/device_host.hpp"
#include "haptic_server/driver_watch.hpp"
#include "haptic_server/hand_view.hpp"
#include "haptic_server/haptic_loop.hpp"
#include "haptic_server/recording/recorder.hpp"
#include "haptic_server/safety/guardian.hpp"
#include "haptic_server/safety/tick_watchdog.hpp"
#include "haptic_server/server.hpp"
#include "shared/publication/scene_segment.hpp"
#include "shared/publication/segment_watch.hpp"
#include "shared/publication/tool_segment.hpp"

namespace stillgrid::haptic_server {

using SceneWatch = publication::SegmentWatch<HandView>;

/// Everything one run needs, made before the loop starts.
struct Run {
  const HapticOptions& options;
  HapticReport& report;
  const std::atomic<bool>& stop;
  std::uint64_t period_ns;
  device::Device& device;
  SceneWatch& watch;
  publication::ToolWriter& tool;
  HapticLoop& loop;
  DriverWatch& driver;
  recording::Recorder* recorder;
  safety::TickWatchdog& watchdog;
  safety::GuardedState& guarded;
};

/// Activates the device, and ticks until the duration is over, the run is stopped or the device's
/// recording has ended; in real time only once the force has faded, but for the recording.
///
/// Throws DeviceFault, DeviceError, and SegmentError where a lockstep peer died. No tick comes
/// after that; the device may still be active.
void run_real_time(Run& run);
void run_lockstep(Run& run);

}  // namespace stillgrid::haptic_server
