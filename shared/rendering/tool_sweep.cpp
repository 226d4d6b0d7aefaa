#include "shared/rendering/tool_sweep.hpp"

#include <cmath>

namespace stillgrid::rendering {
collision::SweptBound bound_tool_sweep(const PlacedToolSphere& probe) noexcept {
  const double moved_m2 = (probe.position_m - probe.before_m).squaredNorm();
  if (is_short_sweep(moved_m2, probe.radius_m))
    return collision::bound_sphere(probe.position_m,
                                   probe.radius_m + (moved_m2 > 0.0 ? std::sqrt(moved_m2) : 0.0));
  return collision::bound_sweep(probe.before_m, probe.position_m, probe.radius_m);
}

std::optional<Eigen::Vector3d> closest_line_m(const Eigen::Vector3d& before_m,
                                              const Eigen::Vector3d& now_m,
                                              double contact_distance_m,
                                              double tool_radius_m) noexcept {
  const Eigen::Vector3d sweep_m = now_m - before_m;
  const double sweep_m2 = sweep_m.squaredNorm();
  if (is_short_sweep(sweep_m2, tool_radius_m) ||
      !(before_m.squaredNorm() >= contact_distance_m * contact_distance_m))
    return std::nullopt;
  const double share = -before_m.dot(sweep_m) / sweep_m2;
  if (!(share > 0.0 && share < 1.0)) return std::nullopt;
  const Eigen::Vector3d line_m = before_m + share * sweep_m;
  const double distance_m2 = line_m.squaredNorm();
  if (!(distance_m2 < contact_distance_m * contact_distance_m)) return std::nullopt;
  // Through the centre there is no side but the one it came from.
  constexpr double kCentral = 1e-6;
  if (distance_m2 < kCentral * kCentral * contact_distance_m * contact_distance_m)
    return kCentral * contact_distance_m * before_m.normalized();
  return line_m;
}

}  // namespace stillgrid::rendering
