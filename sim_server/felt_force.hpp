#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "shared/display/transition.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/contacts/contact_memory.hpp"
#include "sim_server/hand_path.hpp"
#include "sim_server/lockstep_simulation.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// How a scene is shown to a hand.
struct FeltOptions {
  display::Transition transition = display::Transition::kPredict;  // as haptic_server's default
  double latency_s = 0.0;                                          // virtual cost of a step
  double first_share = 1.0;  // of its period, that the first step takes
  double duration_s = 0.0;   // of the hand's path
  double deadline_s = 0.0;   // by the clock: a run that has lasted so long ends
};

/// A world that moved, and the state of its contacts. A run begins with both.
struct StartState {
  bodies::World world;
  std::vector<std::byte> contacts = {};  // see Simulation::contact_state()
};

/// What a hand feels, once a millisecond, and what that costs the simulation.
struct FeltForce {
  std::vector<Eigen::Vector3d> force_N;  // as rendered, in the scene's frame
  std::vector<bool> touches;             // whether the tick was in contact
  double processor_share = 0.0;          // of the simulation: steps, predictions, snapshots
  double slow_step_share = 0.0;          // of the period: what 19 of 20 steps take at most
  std::string failure = {};              // why it ended early; empty: it did not
};

/// Leads a hand through a scene, both rates in this thread and in virtual time: the simulation
/// takes the tool when lockstep would and publishes snapshots, from which the force is rendered at
/// 1 kHz. The forces are those of both servers with --lockstep on that path, but for its rounding.
///
/// start: of build_world(scene). Throws SegmentError. Thread: any. Not real-time.
[[nodiscard]] FeltForce felt_force(const scene::SceneDescription& scene, const StartState& start,
                                   const HandPath& hand, const FeltOptions& options,
                                   const CostClock& now_s);

/// The truth that others are held against, and what they begin with too.
struct TrueForce {
  StartState start;
  FeltForce felt;
};

/// The scene comes to rest for hand->settle_s; then implicit Euler at 1 kHz follows the hand, each
/// snapshot shown at once. Throws SegmentError. Pre: scene.hand; as felt_force().
[[nodiscard]] TrueForce true_force(const scene::SceneDescription& scene, const bodies::World& start,
                                   const HandPath& hand, double deadline_s, const CostClock& now_s);

/// How far a force is from the true one, as a share of that, over the ticks that both have and in
/// which either is in contact; rms. Negative: there is no such tick.
[[nodiscard]] double force_error_share(const FeltForce& force, const FeltForce& truth);

}  // namespace stillgrid::sim_server
