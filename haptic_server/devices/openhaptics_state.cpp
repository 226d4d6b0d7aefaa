#include "haptic_server/devices/openhaptics_state.hpp"

#include "haptic_server/devices/rigid_reading.hpp"

namespace stillgrid::devices {

HdEffect effect_of(unsigned error_code) noexcept {
  constexpr unsigned kWarmMotors = 0x0200;
  constexpr unsigned kGroup = 0xFF00;
  switch (error_code & kGroup) {
    case 0x0000:  // success
    case 0x0100:  // of the call, not of the device
      return HdEffect::kNone;
    case 0x0200:  // of forces
      return error_code == kWarmMotors ? HdEffect::kHot : HdEffect::kFault;
    case 0x0300:  // of the device
    case 0x0600:  // of the licence
      return HdEffect::kLost;
    default:
      return HdEffect::kFault;
  }
}

std::optional<HdPose> pose_of(const std::array<double, 16>& transform) noexcept {
  constexpr double kMetres = 1e-3;
  const Eigen::Map<const Eigen::Matrix4d> matrix(transform.data());  // column by column
  const auto rotation = rotation_of(matrix.topLeftCorner<3, 3>());
  const Eigen::Vector3d position_m = kMetres * matrix.topRightCorner<3, 1>();
  if (!rotation || !is_position(position_m)) return std::nullopt;
  return HdPose{position_m, *rotation};
}

}  // namespace stillgrid::devices
