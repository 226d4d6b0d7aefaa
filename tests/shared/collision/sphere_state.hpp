#pragma once

#include <Eigen/Core>

#include "shared/collision/sphere_history.hpp"

namespace stillgrid::collision {

/// A sphere at one instant, as a snapshot tells it.
[[nodiscard]] inline proto::SphereState sphere_state(
    const Eigen::Vector3d& position_m,
    const Eigen::Vector3d& velocity_m_s = Eigen::Vector3d::Zero()) {
  const Eigen::Vector3f p = position_m.cast<float>(), v = velocity_m_s.cast<float>();
  return {{p.x(), p.y(), p.z()}, {v.x(), v.y(), v.z()}};
}

/// A sphere that stands still at one place in all snapshots.
[[nodiscard]] inline proto::SphereRecord static_sphere(const std::array<float, 3>& position_m,
                                                       float radius_m) {
  proto::SphereRecord sphere{};
  const proto::SphereState snapshot{position_m, {0.0F, 0.0F, 0.0F}};
  fill_history(sphere, snapshot);
  sphere.radius_m = radius_m;
  return sphere;
}

}  // namespace stillgrid::collision
