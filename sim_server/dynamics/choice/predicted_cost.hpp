#pragma once

#include "sim_server/bodies/world.hpp"
#include "sim_server/scene/method.hpp"

namespace stillgrid::dynamics {

/// What decides a method's cost in a scene, counted before any step.
struct SceneLoad {
  double springs = 0.0, joints = 0.0, nodes = 0.0, rigid_bodies = 0.0, spheres = 0.0;
  double unknowns = 0.0;
  double sheet_springs = 0.0;  // of them, those of regular sheets
  double solid_springs = 0.0;  // and of solids
  double factor_ns = 0.0;      // of the Jacobian's factors, by the bodies' shapes
  double spring_rad_s = 0.0;   // highest frequency of springs and joints
  double contact_rad_s = 0.0;  // the same of a body whose spheres touch on one side
  double damping_1_s = 0.0;    // highest rate c / m of their dampers
};

/// Counts a world as it is, all awake.
[[nodiscard]] SceneLoad load_of(const bodies::World& world);

/// Longest step at which symplectic Euler is stable: h^2 w^2 + 2 h c/m < 4 (springs and contacts
/// together). Infinite without either.
[[nodiscard]] double symplectic_limit_s(const SceneLoad& load);

/// Equal substeps of a step of step_s at which symplectic Euler and Verlet are stable, with a tenth
/// to spare for what springs stiffen.
[[nodiscard]] int stable_substeps(const SceneLoad& load, double step_s);

/// Returns how many substeps explicit methods take in a step of step_s where none are given.
[[nodiscard]] int taken_substeps(const SceneLoad& load, double step_s);

/// What a step of step_s should cost, ms: counts times the cost of each operation as measured in
/// tests/performance, right within two for explicit methods on springs, less so where contacts are
/// many.
[[nodiscard]] double predicted_ms(const SceneLoad& load, const scene::Method& method,
                                  double step_s);

}  // namespace stillgrid::dynamics
