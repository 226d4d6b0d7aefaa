#pragma once

#include <Eigen/Core>
#include <optional>

#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::rendering {

/// Whether a way, of which this is the square, is not swept: shorter than half of the tool sphere's
/// radius, or no number. Realtime: yes.
[[nodiscard]] inline bool is_short_sweep(double sweep_m2, double tool_radius_m) noexcept {
  const double short_m = 0.5 * tool_radius_m;
  return !(sweep_m2 > short_m * short_m);
}

/// A ball that the tool sphere did not leave since the tick before. Realtime: yes.
[[nodiscard]] collision::SweptBound bound_tool_sweep(const PlacedToolSphere& probe) noexcept;

/// The line from the sphere to the tool when they were closest, if they moved far past one another
/// and touched only on the way: before_m and now_m lead from the sphere to the tool, in the tick
/// before and now. Realtime: yes.
[[nodiscard]] std::optional<Eigen::Vector3d> closest_line_m(const Eigen::Vector3d& before_m,
                                                            const Eigen::Vector3d& now_m,
                                                            double contact_distance_m,
                                                            double tool_radius_m) noexcept;

}  // namespace stillgrid::rendering
