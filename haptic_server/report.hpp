#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "haptic_server/device/device_identity.hpp"
#include "haptic_server/recording/recorder.hpp"
#include "haptic_server/safety/energy_observer.hpp"
#include "haptic_server/safety/interface_account.hpp"
#include "haptic_server/safety/safety_flag.hpp"
#include "proto/device_plugin.h"
#include "proto/segment_header.hpp"
#include "shared/realtime/histogram.hpp"
#include "shared/realtime/realtime_guard.hpp"
#include "shared/realtime/rights/realtime_rights.hpp"
#include "shared/rendering/renderer.hpp"

namespace stillgrid::haptic_server {

/// Counters of a run, for --report. The loop adds to them; nobody else reads before its end.
struct HapticReport {
  std::string scene, device, transition;
  device::DeviceIdentity device_identity;
  stillgrid_device_descriptor descriptor{};  // what the device declares
  double rate_hz = 0.0;
  bool measures_time = false;  // lockstep has no wall time to report

  std::uint64_t ticks = 0, missed_ticks = 0, contact_ticks = 0, plateau_ticks = 0;
  std::uint64_t local = 0, swaps = 0;  // ticks that were local, and copies that were replaced
  std::uint64_t snapshots = 0, contended = 0, lost_rows = 0;
  std::array<std::uint64_t, safety::kSafetyFlagNames.size()> flags{};
  realtime::Histogram tick_ns, wake_ns, age_ns, slew_uN_per_ms, switch_jump_uN, local_ticks;
  safety::HandEnergy energy;
  std::optional<safety::InterfaceEnergy> interface;  // of the last scene; none: not known
  double force_sum_N = 0.0, force_max_N = 0.0, energy_J = 0.0;
  std::uint64_t device_stops = 0;            // by the watchdog
  std::uint64_t reopenings = 0;              // tries to open a device that was lost
  std::optional<double> temperature_max_C;   // as the device tells
  std::optional<proto::RelayFigures> relay;  // of the last scene; none: no relay wrote it
  realtime::RealtimeRights rights;           // of the thread that ticks; lockstep needs none
  long page_faults = 0;
  std::optional<std::vector<realtime::RealtimeViolation>>
      realtime_violations;  // with --realtime-guard only
};

/// Counts one tick. previous_N: the force of the tick before, moved_m: of the device since then,
/// both in one frame and the device's own scale. Realtime: yes.
void count_tick(HapticReport& report, const recording::TickRow& row,
                const rendering::RenderedTick& rendered, const Eigen::Vector3d& previous_N,
                const Eigen::Vector3d& moved_m, double tick_s) noexcept;

/// Writes the report of docs/formats.md, "Reports". Throws std::runtime_error if it cannot be
/// written.
void write_report(const HapticReport& report, const std::filesystem::path& file);

}  // namespace stillgrid::haptic_server
