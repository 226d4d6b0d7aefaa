#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>

namespace stillgrid::devices {

/// What an error of the servo loop means for the hand.
enum class HdEffect {
  kNone,   // a call that this device does not know
  kHot,    // warm motors
  kFault,  // the device's own limits were passed, or a frame was broken: no force for a while
  kLost,   // the device does not answer, has failed, or may not be used: the run's end
};

/// The effect of an error code that hdGetError() returned. One that is not known is a fault.
/// Realtime: yes.
[[nodiscard]] HdEffect effect_of(unsigned error_code) noexcept;

/// A sensed pose in metres.
struct HdPose {
  Eigen::Vector3d position_m;
  Eigen::Quaterniond orientation;
};

/// The pose of a transform of the HD API, 4 by 4 column by column, millimetres; nothing where it is
/// no rotation, or no place within 10 m. Realtime: yes.
[[nodiscard]] std::optional<HdPose> pose_of(const std::array<double, 16>& transform) noexcept;

}  // namespace stillgrid::devices
