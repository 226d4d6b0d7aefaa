#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

namespace stillgrid::devices {

/// Whether a position can be one of a device on a desk: finite and within 10 m. Realtime: yes.
[[nodiscard]] inline bool is_position(const Eigen::Vector3d& position_m) noexcept {
  constexpr double kFarthest_m = 10.0;
  return position_m.allFinite() && position_m.norm() <= kFarthest_m;
}

/// The unit quaternion of a rotation's matrix; nothing where it is none. Realtime: yes.
[[nodiscard]] inline std::optional<Eigen::Quaterniond> rotation_of(
    const Eigen::Matrix3d& matrix) noexcept {
  constexpr double kRounding = 1e-3;
  if (!matrix.allFinite() || matrix.determinant() < 0.5 ||
      (matrix * matrix.transpose() - Eigen::Matrix3d::Identity()).norm() > kRounding) {
    return std::nullopt;
  }
  return Eigen::Quaterniond(matrix).normalized();
}

}  // namespace stillgrid::devices
