#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

#include "proto/scene_segment.hpp"
#include "shared/display/response.hpp"
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
/// by the same weights: a sum of quaternions made a unit, which for two is their slerp but for a
/// share of the angle's third power, turned on for as long as velocities lead the origin on.
/// Nothing where a snapshot that weighs is no state of a body. Realtime: yes; safe on numbers that
/// lie.
[[nodiscard]] std::optional<DisplayedField> displayed(const proto::FieldRecord& record,
                                                      const SnapshotWeights& weights) noexcept;

/// How the body's points move at its predicted velocities, from where it is displayed.
[[nodiscard]] DisplayedField led_on(const DisplayedField& shown,
                                    const proto::FieldRecord& record) noexcept;

/// How a body that has a field gives way in each mode of a snapshot.
struct FieldResponse {
  ResponseMatrix origin = ResponseMatrix::Zero();  // sqrt(m/N)
  ResponseMatrix turn = ResponseMatrix::Zero();    // rad / sqrt(J)

  /// Of the body's point so far from its frame's origin, world frame.
  [[nodiscard]] ResponseMatrix at(const Eigen::Vector3d& arm_m) const noexcept {
    ResponseMatrix response = origin;
    const Eigen::Vector3f arm = arm_m.cast<float>();
    for (Eigen::Index mode = 0; mode < response.cols(); ++mode)
      response.col(mode) += turn.col(mode).cross(arm);
    return response;
  }
};

/// The response of a field of a moving grid; none where it has none, or its record lies.
/// Realtime: yes. Pre: finite largest_response.
[[nodiscard]] std::optional<FieldResponse> response_of(const collision::GridView& grid,
                                                       const proto::FieldRecord& record,
                                                       double largest_response) noexcept;

/// The body where the modes move it: its origin straight on, and it turns. Realtime: yes.
[[nodiscard]] DisplayedField given_way(const DisplayedField& shown, const FieldResponse& response,
                                       const ModeDisplacements& displacements) noexcept;

}  // namespace stillgrid::display
