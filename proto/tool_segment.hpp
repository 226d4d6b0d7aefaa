#pragma once

#include "proto/segment_header.hpp"

namespace stillgrid::proto {

/// Pose and force of the tool: haptic_server writes it every tick, sim_server reads the latest.
/// Scene frame, SI units. Layout and lifetime: docs/protocol.md.
struct ToolState {
  std::uint64_t time_ns;                   // the haptic clock, when the device was read
  std::uint64_t tick;                      // number of the tick, from 1
  std::array<double, 3> position_m;        // tool origin
  std::array<double, 4> orientation_xyzw;  // unit quaternion, scene from tool
  std::array<double, 3> velocity_m_s;      // the server's estimate
  std::array<double, 3> force_N;  // on the hand over the tick before, after the safety chain
  std::uint64_t buttons;
};
static_assert(std::is_trivially_copyable_v<ToolState> && sizeof(ToolState) == 128);

inline constexpr std::uint64_t kToolLayoutHash =
    layout_hash<4>({sizeof(SegmentHeader), offsetof(SegmentHeader, latest),
                    offsetof(SegmentHeader, lockstep_sample_ns), sizeof(ToolState)});

}  // namespace stillgrid::proto
