#pragma once

#include <Eigen/Core>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics {

/// How a block moves on a slope.
struct Slide {
  double velocity_m_s, acceleration_m_s2;  // down the slope
  double across_m_s, off_m_s;
};

/// A flat block of friction 0.3, some steps of 1 ms after a slope of 10 degrees, on which it crept
/// for others, was tilted to angle_deg. Gravity is what tilts.
[[nodiscard]] inline Slide slide_on(double angle_deg, const scene::Method& method,
                                    int creeping_steps, int steps) {
  const auto gravity_m_s2 = [](double tilt_deg) -> Eigen::Vector3d {
    const double tilt_rad = tilt_deg * std::numbers::pi / 180.0;
    return 9.81 * Eigen::Vector3d(std::sin(tilt_rad), 0, -std::cos(tilt_rad));
  };
  scene::SceneDescription scene =
      sim_server::scene_of({sim_server::box({0, 0, 0.01}, {0.06, 0.06, 0.02}, 0.1, {0.05, 0.005}),
                            sim_server::floor_at(0.0)},
                           sim_server::material_of(500.0, 2.0, 0.3, 1e-3), gravity_m_s2(10.0));
  scene.method = method;
  Simulation simulation(scene);
  const Eigen::Vector3d& velocity_m_s = simulation.world().rigid_bodies[0].velocity_m_s;
  constexpr int kLast = 100;
  REQUIRE(advance(simulation, 1e-3, creeping_steps));
  simulation.world().gravity_m_s2 = gravity_m_s2(angle_deg);
  REQUIRE(advance(simulation, 1e-3, steps - kLast));
  const double before_m_s = velocity_m_s.x();
  REQUIRE(advance(simulation, 1e-3, kLast));
  return {velocity_m_s.x(), (velocity_m_s.x() - before_m_s) / 0.1, velocity_m_s.y(),
          velocity_m_s.z()};
}

}  // namespace stillgrid::dynamics
