#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

#include "proto/scene_segment.hpp"
#include "shared/display/transition.hpp"

namespace stillgrid::display {

/// The frame of a body with a field as it is displayed, and how it moves. World frame.
struct DisplayedField {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();       // of the frame's origin
  Eigen::Matrix3d orientation = Eigen::Matrix3d::Identity();  // world from body
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();

  [[nodiscard]] Eigen::Vector3d into(const Eigen::Vector3d& point_m) const noexcept {
    return orientation.transpose() * (point_m - position_m);
  }
  [[nodiscard]] Eigen::Vector3d out_of(const Eigen::Vector3d& point_m) const noexcept {
    return position_m + orientation * point_m;
  }
  /// Of the body's point that is there, in the world frame.
  [[nodiscard]] Eigen::Vector3d velocity_at(const Eigen::Vector3d& point_m) const noexcept {
    return velocity_m_s + angular_velocity_rad_s.cross(point_m - position_m);
  }
};

/// Of a body that never moves. Pre: is_sound(state).
[[nodiscard]] DisplayedField displayed(const proto::FieldState& state) noexcept;

/// Where the weights display the frame: its origin as a sphere's centre is displayed, and its turn
/// by the same weights: a sum of two quaternions made a unit, which is their slerp but for a share
/// of the angle's third power.
/// Nothing where a snapshot that weighs is no state of a body. Realtime: yes; safe on numbers that
/// lie.
[[nodiscard]] std::optional<DisplayedField> displayed(const proto::FieldRecord& record,
                                                      const SnapshotWeights& weights) noexcept;

}  // namespace stillgrid::display
