#pragma once

#include <catch2/catch.hpp>
#include <cmath>

#include "shared/dynamics/implicit_step.hpp"
#include "tests/shared/dynamics/engine_scenes.hpp"

namespace stillgrid::dynamics {

inline const EngineMethod kImplicit = implicit_euler();

/// Runs a test by each method.
inline EngineMethod each_method() {
  return GENERATE(EngineMethod{}, kImplicit);
}

inline void run_implicit(Engine& engine, double duration_s, double step_s) {
  for (int k = 0; k < std::lround(duration_s / step_s); ++k) {
    engine.step({}, step_s);
    REQUIRE(engine.solve().converged);
  }
}
inline Eigen::Vector3d place_of(const Description::JointEnd& end, const SceneState& state) {
  if (end.node >= 0) return state.node_position_m[static_cast<std::size_t>(end.node)].vector();
  if (end.rigid < 0) return end.point_m;
  const auto r = static_cast<std::size_t>(end.rigid);
  return state.rigid_position_m[r].vector() + state.orientation[r].quaternion() * end.point_m;
}

/// Kinetic and potential energy of a scene, J.
inline double energy_J(const Engine& engine) {
  const Description& scene = engine.description();
  const SceneState& state = engine.state();
  double sum_J = engine.contact_energy_J();
  for (std::size_t i = 0; i < scene.nodes.size(); ++i)
    if (!scene.nodes[i].is_pinned)
      sum_J += scene.nodes[i].mass_kg * (0.5 * state.node_velocity_m_s[i].vector().squaredNorm() -
                                         scene.gravity_m_s2.dot(state.node_position_m[i].vector()));
  for (std::size_t r = 0; r < scene.rigid_bodies.size(); ++r) {
    const Description::Rigid& body = scene.rigid_bodies[r];
    if (body.is_driven) continue;
    const Eigen::Vector3d spin =
        state.orientation[r].quaternion().conjugate() * state.angular_velocity_rad_s[r].vector();
    sum_J += body.mass_kg * (0.5 * state.rigid_velocity_m_s[r].vector().squaredNorm() -
                             scene.gravity_m_s2.dot(state.rigid_position_m[r].vector())) +
             0.5 * spin.dot(body.inertia_kg_m2.cwiseProduct(spin));
  }
  const auto stretched_J = [](double stiffness, double length, double rest) {
    return 0.5 * stiffness * (length - rest) * (length - rest);
  };
  for (const Description::Spring& spring : scene.springs)
    sum_J += stretched_J(spring.stiffness_N_per_m,
                         (state.node_position_m[static_cast<std::size_t>(spring.a)] -
                          state.node_position_m[static_cast<std::size_t>(spring.b)])
                             .vector()
                             .norm(),
                         spring.rest_length_m);
  for (const Description::Joint& joint : scene.joints)
    sum_J += stretched_J(joint.stiffness_N_per_m,
                         (place_of(joint.a, state) - place_of(joint.b, state)).norm(),
                         joint.rest_length_m);
  return sum_J;
}

/// The largest gain of energy in one step, as a share of the scale.
inline double largest_gain(Engine& engine, double duration_s, double step_s, double scale_J) {
  double most = 0.0, before_J = energy_J(engine);
  for (int k = 0; k < std::lround(duration_s / step_s); ++k) {
    engine.step({}, step_s);
    const double now_J = energy_J(engine);
    most = std::max(most, now_J - before_J);
    before_J = now_J;
  }
  return most / scale_J;
}

}  // namespace stillgrid::dynamics
