#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>

#include "haptic_server/device/device_host.hpp"
#include "haptic_server/report.hpp"
#include "haptic_server/safety/device_limits.hpp"
#include "haptic_server/safety/guardian.hpp"
#include "shared/rendering/renderer.hpp"

namespace stillgrid::haptic_server {

struct HapticOptions {
  std::string session;  // of the hand
  std::string device;   // "PLUGIN[:key=value,...]"
  double rate_hz = 1000.0;
  std::optional<display::Transition> transition;  // else rendering::default_transition()
  bool lockstep = false;
  std::optional<double> duration_s;  // else until stopped, or the device's recording ends
  safety::SafetyOptions safety;
  std::filesystem::path record;  // empty: none
  std::string version;           // of the program, for the recording
  std::optional<int> cpu;
  std::filesystem::path commands;  // orders while ticks go on; may be empty
  int clutch_button = -1;          // -1: no clutch
  std::uint64_t reopenings = 0;    // tries in the run to open a device again that was lost
  std::optional<gid_t> readers;    // a group that may read the tool's segment
  // The ticks are over and recorded, the motors off; the device is yet to be closed. Thread: the
  // loop's.
  std::function<void()> ended;
  // A driver does not come back from a call, or ends the program: ends the process. Thread: the
  // watchdog's, or the one that the driver was called from.
  std::function<void(const std::string& line)> give_up;
};

/// The device stopped answering while the loop ran.
class DeviceFault : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Runs the haptic loop until its duration is over, the device's recording ends, or stop is set;
/// counts what happened in report, also when it throws. guarded is told of motors that are on.
///
/// Throws DeviceError, DeviceFault, or SegmentError if there is no scene in time or a lockstep peer
/// dies.
void run_haptics(const HapticOptions& options, HapticReport& report, safety::GuardedState& guarded,
                 const std::atomic<bool>& stop);

}  // namespace stillgrid::haptic_server
