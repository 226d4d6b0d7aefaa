#pragma once

#include "sim_server/bodies/world.hpp"
#include "sim_server/scene/method.hpp"

namespace stillgrid::dynamics {

/// What decides a method's cost in a scene, counted before any step.
struct SceneLoad {
  double springs = 0.0, joints = 0.0, nodes = 0.0, rigid_bodies = 0.0, spheres = 0.0;
  double sheet_springs = 0.0;  // of them, those of regular sheets
  double spring_rad_s = 0.0;   // highest frequency of springs and joints
  double contact_rad_s = 0.0;  // the same of a body whose spheres touch on one side
  double damping_1_s = 0.0;    // highest rate c / m of their dampers
};

/// Counts a world as it is, all awake.
[[nodiscard]] SceneLoad load_of(const bodies::World& world);

/// Longest step at which velocity Verlet is stable: h^2 w^2 + 2 h c/m < 4 (springs and contacts
/// together). Infinite without either.
[[nodiscard]] double stable_step_s(const SceneLoad& load);

/// Equal substeps of a step of step_s at which velocity Verlet is stable, with a tenth to spare for
/// what springs stiffen.
[[nodiscard]] int stable_substeps(const SceneLoad& load, double step_s);

/// Returns how many substeps explicit methods take in a step of step_s where none are given.
[[nodiscard]] int taken_substeps(const SceneLoad& load, double step_s);

/// Counted work of a step.
struct StepWork {
  double parts = 1.0;       // for each of which contacts are detected
  double iterations = 0.0;  // of the solver; of velocity_verlet its substeps
  double products = 0.0;    // with the Jacobian
  double contacts = 0.0;    // that touch at the step's end
};

/// Cost of a step, ms: its counts times the cost of each operation as measured in
/// tests/performance. The same on every machine.
[[nodiscard]] double cost_ms(const SceneLoad& load, const scene::Method& method,
                             const StepWork& work);

}  // namespace stillgrid::dynamics
