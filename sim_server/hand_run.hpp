#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "shared/display/transition.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/hand_path.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// How a scene is shown to a hand.
struct HandRunOptions {
  display::Transition transition = display::Transition::kLocal;  // haptic_server's default
  double latency_s = 0.0;                                        // virtual cost of a step
  double first_share = 1.0;  // length of the first step, as a share of its period
  double duration_s = 0.0;   // hand's path
  double beside_m = 0.0;     // offset of the hand's path along each axis
  // The hand feels the friction of the engine. A truth has short steps and therefore no copy.
  bool has_engine_friction = false;
  // A run ends when its mean after 0.1 s costs more.
  double most_work_per_ms = std::numeric_limits<double>::infinity();
};

/// A world at rest and the state of its contacts: the start of a run.
struct StartState {
  bodies::World world;
  std::vector<std::byte> contacts = {};  // see Simulation::contact_state()
};

/// The force on a hand at each millisecond, and the counted work of each step.
struct HandRun {
  std::vector<Eigen::Vector3d> force_N;  // rendered, in the scene's frame
  std::vector<bool> touches;             // whether the tick was in contact
  std::vector<double> step_work;         // dynamics::work_of()
  double all_work = 0.0;                 // sum over the steps
  std::string failure = {};              // why the run ended early; empty: it did not

  [[nodiscard]] double work_per_ms() const;
  /// Returns the work that 19 of 20 steps do not exceed, as a share of a processor.
  [[nodiscard]] double slow_step_share(double period_s) const;
};

/// Returns the step by which a scene without a tool moves as by its own period. It is a tick of a
/// method that divides steps into ticks, else the period.
[[nodiscard]] double rest_step_s(const scene::SceneDescription& scene);

/// Steps the scene for settle_s of its hand without a tool, by its own method and rest_step_s().
/// Stops if that costs more than most_work_per_ms. start: a world of this scene. Throws
/// std::domain_error if the world diverges.
[[nodiscard]] StartState settled(scene::SceneDescription scene, const bodies::World& start,
                                 double most_work_per_ms = std::numeric_limits<double>::infinity());

/// Leads a hand through a scene, both rates in this thread and in virtual time. The simulation
/// follows the tool as it does in lockstep and publishes snapshots; the force is rendered from them
/// at 1 kHz. Steps shorter than a millisecond take a sample of the tool each. The forces are those
/// of both servers with --lockstep on that path, but for its rounding. No clock is read.
///
/// Throws SegmentError. Thread: any. Not real-time.
[[nodiscard]] HandRun run_hand(const scene::SceneDescription& scene, const StartState& start,
                               const HandPath& hand, const HandRunOptions& options);

/// Returns the rms of the force's error over the true force's rms, over the ticks in contact.
/// Negative: there is no such tick.
[[nodiscard]] double force_error_share(const HandRun& run, const HandRun& truth);

}  // namespace stillgrid::sim_server
