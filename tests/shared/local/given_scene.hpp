#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "shared/local/given_bodies.hpp"

namespace stillgrid::local {

/// A model of one material and balls of 5 mm as tools, without friction and damping.
inline GivenModel ball_model(double stiffness_N_per_m, std::size_t hands = 1,
                             std::uint64_t period_ticks = 40) {
  GivenModel model;
  model.period_ticks = period_ticks;
  model.materials = {{stiffness_N_per_m, 0.0, 0.0, 1e-3}};
  model.tools.assign(hands, {.spheres = {{.radius_m = 0.005}}});
  return model;
}

inline Matrix6 ball_inertia(double mass_kg, double radius_m) {
  Twist inverse = Twist::Constant(1.0 / mass_kg);
  inverse.tail<3>().setConstant(2.5 / (mass_kg * radius_m * radius_m));
  return inverse.asDiagonal();
}

/// A free ball of one sphere at the origin.
inline GivenState one_ball(double mass_kg, double radius_m) {
  GivenState state;
  state.bodies = {{.number = 7, .inverse_inertia = ball_inertia(mass_kg, radius_m)}};
  state.spheres = {{.number = 3, .radius_m = radius_m}};
  return state;
}

using Tools = std::vector<std::optional<dynamics::ToolPose>>;
inline dynamics::ToolPose tool_at(const Eigen::Vector3d& position_m,
                                  const Eigen::Vector3d& velocity_m_s = Eigen::Vector3d::Zero()) {
  return {position_m, Eigen::Quaterniond::Identity(), velocity_m_s};
}

}  // namespace stillgrid::local
