#pragma once

#include <string>

#include "sim_server/bodies/world.hpp"
#include "sim_server/scene/method.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::dynamics {

/// Counts of a scene that decide the work of its steps, before any step.
struct SceneLoad {
  double springs = 0.0, joints = 0.0, nodes = 0.0, rigid_bodies = 0.0, spheres = 0.0;
  double sheet_springs = 0.0;  // the part of `springs` in regular sheets
  double spring_rad_s = 0.0;   // highest frequency of springs and joints
  double contact_rad_s = 0.0;  // highest of a body whose spheres touch on one side
  double damping_1_s = 0.0;    // highest rate c / m of their dampers
};

/// Counts a world as it is, all awake.
[[nodiscard]] SceneLoad load_of(const bodies::World& world);

/// Longest step at which velocity Verlet is stable: h^2 w^2 + 2 h c/m < 4 (springs and contacts
/// together). Infinite without either.
[[nodiscard]] double stable_step_s(const SceneLoad& load);

/// Returns the equal substeps of a step of step_s at which velocity Verlet is stable, with a tenth
/// to spare for springs that stiffen.
[[nodiscard]] int stable_substeps(const SceneLoad& load, double step_s);

/// Returns the default number of substeps of explicit methods in a step of step_s.
[[nodiscard]] int taken_substeps(const SceneLoad& load, double step_s);

/// Counts of a step.
struct StepCounts {
  double parts = 1.0;       // for each of which contacts are detected
  double iterations = 0.0;  // the solver's, or velocity_verlet's substeps
  double products = 0.0;    // Jacobian times vector
  double contacts = 0.0;    // that touch at the step's end
};

/// Returns the work of a step, in evaluations of one spring: each count times its weight. The
/// weights fit processor times of the shipped scenes. The work is the same on every machine.
[[nodiscard]] double work_of(const SceneLoad& load, const scene::Method& method,
                             const StepCounts& counts);

/// Work that one processor of the reference machine does in a millisecond.
inline constexpr double kWorkPerProcessor_ms = 1.7e5;

/// Most substeps of velocity_verlet in a tick that cost less than a tick by implicit_euler.
inline constexpr int kMaxSubsteps = 16;

/// A method, and the reason in words.
struct MethodChoice {
  scene::Method method;
  std::string why;
};

/// Chooses the method of integrator = "auto" by the spectrum. Velocity_verlet is chosen where at
/// most kMaxSubsteps substeps keep it stable in each tick of a step of step_s.
[[nodiscard]] MethodChoice choose_method(const SceneLoad& load, double step_s);

/// Sets rate and method of a scene that names neither: 1 kHz by velocity_verlet. Both stay as they
/// are if the work of such a step exceeds a quarter of a processor. world: build_world(scene).
void settle_step(scene::SceneDescription& scene, const bodies::World& world);

}  // namespace stillgrid::dynamics
