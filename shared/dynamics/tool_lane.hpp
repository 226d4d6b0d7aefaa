#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace stillgrid::dynamics {

/// A lane of a row with a tool's sphere that has a proxy.
///
/// The tool is as deep in the other side as in the half-space at the proxy: shift_m moves its
/// sphere there, for a tick. A field is a sphere that touches the half-space and moves with its
/// body.
struct ToolLane {
  std::uint32_t row = 0, lane = 0;
  std::int32_t tool = 0;                                     // index into ContactListing::tools()
  std::int32_t other = 0;                                    // number of Description::side()
  bool is_a = false;                                         // the tool's sphere is side a
  Eigen::Vector3d apart_m = Eigen::Vector3d::Zero();         // that of the row without shift_m
  float stiffness_N_per_m = 0.0F, damping_N_s_per_m = 0.0F;  // without share
  double share = 1.0;                                        // push over depth of the half-space
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
  bool is_held = false;  // the other side is a field, taken for a sphere at centre_m in its frame
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d ahead_m = Eigen::Vector3d::Zero();  // the other side's centre at the end, as even
                                                      // motion would have it
  double map_scale = 1.0;                             // that of the field at the proxy
};

/// A tool's sphere and a sphere or field that never moves. They push each other in no row: the
/// haptic process alone computes their force.
struct ToolFixture {
  std::int32_t tool = 0;   // index into ContactListing::tools()
  std::int32_t other = 0;  // number of Description::side()
};

}  // namespace stillgrid::dynamics
