#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <utility>
#include <vector>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/field_worlds.hpp"

namespace stillgrid::dynamics {

inline constexpr double kGravity_m_s2 = 9.79;
inline const Eigen::Vector3d kSize_m(0.061, 0.047, 0.033);

/// Every integrator, a step of its own for each family.
struct Way {
  scene::IntegratorKind integrator;
  double step_s;
};
[[nodiscard]] inline Way every_way() {
  using scene::IntegratorKind;
  return GENERATE(Way{IntegratorKind::kVelocityVerlet, 0.0113},
                  Way{IntegratorKind::kImplicitEuler, 0.0113},
                  Way{IntegratorKind::kCvodeBdf, 0.0113});
}

[[nodiscard]] inline scene::SceneDescription scene_by(const Way& way,
                                                      std::vector<bodies::BodyDescription> bodies,
                                                      const scene::MaterialDescription& material,
                                                      double gravity_m_s2 = kGravity_m_s2) {
  scene::SceneDescription scene =
      sim_server::scene_of(std::move(bodies), material, {0, 0, -gravity_m_s2});
  scene.method.integrator = way.integrator;
  if (scene::chooses_steps(way.integrator)) scene.method.tolerance_m_s = 1e-6;
  return scene;
}

[[nodiscard]] inline const bodies::RigidBody& body(const Simulation& simulation,
                                                   std::size_t i = 0) {
  return simulation.world().rigid_bodies[i];
}
[[nodiscard]] inline double fastest_m_s(const Simulation& simulation) {
  double most = 0.0;
  for (const bodies::RigidBody& own : simulation.world().rigid_bodies)
    if (own.free)
      most = std::max(most, own.velocity_m_s.norm() +
                                own.bounding_radius_m * own.angular_velocity_rad_s.norm());
  return most;
}

}  // namespace stillgrid::dynamics
