#pragma once

#include <cstddef>
#include <cstdint>

#include "shared/dynamics/field_geometry.hpp"
#include "shared/dynamics/scene_state.hpp"

namespace stillgrid::dynamics {

/// A lane of a row whose side b is a distance field.
struct FieldLane {
  std::size_t row = 0, lane = 0;
  std::int32_t place = 0, field = 0;  // place of the sphere; index of the field
  double radius_m = 0.0;              // the sphere's
  float stiffness_N_per_m = 0.0F, damping_N_s_per_m = 0.0F;  // without scale
  float stiffness_root = 1.0F;  // root of the scale of stiffness at the last evaluation
  std::int32_t tool_lane = -1;  // index into ContactListing::tool_lanes()
};

/// Pose of a field when contacts were listed.
struct FieldBase {
  Vector4 position_m;  // w: longest way of any point of the solid until the next listing
  Vector4 axes[3];     // columns of FieldPose::axes

  [[nodiscard]] static FieldBase of(const FieldPose& pose, double margin_m) {
    FieldBase base{.position_m = Vector4(pose.position_m), .axes = {}};
    base.position_m.w = margin_m;
    for (int k = 0; k < 3; ++k) base.axes[k] = Vector4(Eigen::Vector3d(pose.axes.col(k)));
    return base;
  }
  [[nodiscard]] FieldPose pose() const {
    FieldPose pose;
    pose.position_m = position_m.vector();
    for (int k = 0; k < 3; ++k) pose.axes.col(k) = axes[k].vector();
    return pose;
  }
};

}  // namespace stillgrid::dynamics
