#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "proto/ros/geometry_msgs.h"
#include "proto/tool_segment.hpp"

namespace stillgrid::scene_relay {

using RosStamp = builtin_interfaces_msg_dds__Time_;
using RosPose = geometry_msgs_msg_dds__PoseStamped_;
using RosWrench = geometry_msgs_msg_dds__WrenchStamped_;

/// One moment, by the haptic loop's clock and by the one that ROS reads.
struct ClockPair {
  std::uint64_t monotonic_ns = 0;
  std::uint64_t wall_ns = 0;  // since 1970, UTC
};

/// Now. The two readings lie within the narrowest of three attempts.
[[nodiscard]] ClockPair read_clocks() noexcept;

/// A stamp of the haptic loop as ROS writes it, by what the two clocks differ by now: after a step
/// of the wall clock, of the new time. Nothing where ROS cannot write it (before 1970, from 2038).
[[nodiscard]] std::optional<RosStamp> ros_stamp(std::uint64_t time_ns,
                                                const ClockPair& now) noexcept;

/// Where the tool is in the scene: its origin and orientation. frame outlives the message.
[[nodiscard]] RosPose pose_message(const proto::ToolState& state, RosStamp stamp,
                                   const std::string& frame) noexcept;

/// Force (N) and torque (N m) on the hand over the tick before the stamp, after the safety chain;
/// along the scene's axes, the torque about the tool's origin. frame outlives the message.
/// Pre: has_sound_figures(state).
[[nodiscard]] RosWrench wrench_message(const proto::ToolState& state, RosStamp stamp,
                                       const std::string& frame) noexcept;

}  // namespace stillgrid::scene_relay
