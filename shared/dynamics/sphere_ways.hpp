#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "shared/dynamics/contact_listing.hpp"
#include "shared/dynamics/description.hpp"
#include "shared/dynamics/scene_state.hpp"

namespace stillgrid::dynamics {

/// Centre of a sphere in m, and how far it moves in a tick at its velocity.
struct SpherePath {
  Eigen::Vector3d from_m, path_m;
};

[[nodiscard]] inline SpherePath sphere_path(const Description::Sphere& sphere,
                                            const SceneState& state, double tick_s) {
  return {sphere_position_m(sphere, state).vector(), tick_s * sphere_velocity_m_s(sphere, state)};
}

/// Least distance of two points, the first of which moves by path_m relative to the second.
[[nodiscard]] inline double least_distance_m(const Eigen::Vector3d& apart_m,
                                             const Eigen::Vector3d& path_m) {
  const double share =
      std::clamp(-apart_m.dot(path_m) / std::max(path_m.squaredNorm(), 1e-300), 0.0, 1.0);
  return (apart_m + share * path_m).norm();
}

}  // namespace stillgrid::dynamics
