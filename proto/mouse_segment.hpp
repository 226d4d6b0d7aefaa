#pragma once

#include "proto/segment_header.hpp"

namespace stillgrid::proto {

/// Pose of the handle that a page's mouse asks for. Writer: scene_viewer, while a page holds the
/// hand. Reader: the device `mouse`. Device frame, SI units. Layout: docs/protocol.md.
struct MousePose {
  std::uint64_t time_ns;  // CLOCK_MONOTONIC, when the viewer received it
  std::array<double, 3> position_m;
  std::array<double, 4> orientation_xyzw;  // unit quaternion, device from tool
  std::uint64_t buttons;                   // one bit each
};
static_assert(std::is_trivially_copyable_v<MousePose> && sizeof(MousePose) == 72);

/// A reader rejects a place farther than this from the device's origin along an axis.
inline constexpr double kFarthestMouse_m = 10.0;

inline constexpr std::uint64_t kMouseLayoutHash =
    layout_hash<4>({sizeof(SegmentHeader), offsetof(SegmentHeader, latest), sizeof(MousePose),
                    offsetof(MousePose, buttons)});

}  // namespace stillgrid::proto
