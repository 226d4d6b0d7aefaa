#pragma once

#include "proto/safety_flag.hpp"
#include "proto/scene_segment.hpp"

namespace stillgrid::proto {

/// Which snapshot of the scene a tick displayed, and where: for those who look on. A sphere was at
/// alpha times its newest position, and the rest of 1 times that of the snapshot before. In a
/// local tick haptic_server stepped the simulation to this tick.
struct DisplayedSnapshot {
  std::uint64_t scene_epoch;  // of the scene's segment
  std::uint64_t snapshot_id;  // 0: none
  double alpha;               // progress of the transition to that snapshot, of 1
  double age_s;               // age of its newest simulated state
  std::uint32_t local_ticks;  // steps of the simulation in this tick
  std::uint32_t is_local;     // 1: a local tick
};

/// Results of a tick. Zeros before the first.
struct TickFigures {
  std::array<double, 3> torque_N_m;  // on the hand, as ToolState::force_N
  std::uint32_t contacts;
  std::uint32_t flags;               // SafetyFlag
  std::uint64_t work_ns;             // from waking to its end; in lockstep 0, as the two below
  std::uint64_t wake_up_latency_ns;  // after its deadline
  std::uint64_t missed_ticks;        // since the loop began
  DisplayedSnapshot displayed;
};

/// What else the device told when it was read, and what its gripper was told.
struct DeviceFigures {
  std::uint32_t told;    // STILLGRID_STATE_GRIPPER, _AXES, _TEMPERATURE: which figures there are
  std::uint32_t status;  // STILLGRID_STATUS_...
  std::uint32_t status_known;
  float temperature_C;
  double gripper_m;        // how far it is open
  double gripper_force_N;  // over the tick before, positive opens
  std::array<double, 4> axes;
};

/// Ticks of 1 ms of the tool's path that its segment keeps, and their length.
inline constexpr std::size_t kPathLength = 4096;
inline constexpr std::uint64_t kPathTick_ns = 1'000'000;

/// The tool's pose in one tick: number n is the moment n * kPathTick_ns of the segment's clock.
/// Its index is n modulo kPathLength. Its number is kNever while it is written.
struct PathSample {
  std::uint64_t number;
  std::array<double, 3> position_m;
  std::array<double, 4> orientation_xyzw;
  std::array<double, 3> velocity_m_s;
};
static_assert(sizeof(PathSample) == 88);

/// The last ticks of the path. Follows SegmentHeader.
struct ToolPath {
  std::uint64_t newest;  // number of the newest sample; kNever before the first
  std::array<PathSample, kPathLength> samples;
};

/// Pose and force of the tool: haptic_server writes it every tick, sim_server reads the latest.
/// Scene frame, SI units. Layout and lifetime: docs/protocol.md.
struct ToolState {
  std::uint64_t time_ns;                   // the haptic clock, when the device was read
  std::uint64_t tick;                      // number of the tick, from 1
  std::uint64_t path_number;               // number of the tick's PathSample
  std::array<double, 3> position_m;        // tool origin
  std::array<double, 4> orientation_xyzw;  // unit quaternion, scene from tool
  std::array<double, 3> velocity_m_s;      // the server's estimate
  std::array<double, 3> force_N;  // on the hand over the tick before, after the safety chain
  std::uint64_t buttons;
  TickFigures before;  // of the tick before
  DeviceFigures device;
};
static_assert(std::is_trivially_copyable_v<ToolState> && sizeof(ToolState) == 296);

inline constexpr std::uint64_t kToolLayoutHash =
    layout_hash<9>({sizeof(SegmentHeader), offsetof(SegmentHeader, latest),
                    offsetof(SegmentHeader, lockstep_sample_ns), sizeof(ToolState),
                    offsetof(ToolState, before), offsetof(ToolState, device),
                    offsetof(TickFigures, displayed), sizeof(PathSample), sizeof(ToolPath)});

}  // namespace stillgrid::proto
