#pragma once

#include <optional>
#include <vector>

#include "proto/tool_segment.hpp"
#include "shared/publication/session.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/lockstep_schedule.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// Returns whether snapshots of the scene hold predictions. At 1 kHz a snapshot is shown for
/// one tick: it needs no prediction.
[[nodiscard]] inline bool predicts(const scene::SceneDescription& scene) {
  return scene.period_s > 1.000001e-3;  // a rounding longer than a millisecond
}

/// Returns whether another process can step the scene in a tick of its hand.
[[nodiscard]] bool can_be_local(const scene::SceneDescription& scene,
                                const dynamics::Simulation& simulation);

/// Returns the fixed part of a hand's segment. with_state, pre: can_be_local(). It has the model
/// that continues from the states of snapshots, and no predictions.
[[nodiscard]] publication::StaticScene static_scene(const scene::SceneDescription& scene,
                                                    const dynamics::Simulation& simulation,
                                                    std::size_t hand = 0, bool with_state = false);

/// Of all its hands.
[[nodiscard]] std::vector<publication::HandScene> hand_scenes(
    const scene::SceneDescription& scene, const dynamics::Simulation& simulation,
    bool with_state = false);

/// The tool as the simulation takes it.
[[nodiscard]] std::optional<dynamics::ToolSample> sample_of(
    const std::optional<proto::ToolState>& state);

/// The stamps of a hand's snapshot of lockstep.
[[nodiscard]] publication::SnapshotTimes times_of(const ScheduledSnapshot& snapshot,
                                                  const dynamics::StepReport& step,
                                                  std::size_t hand = 0);

}  // namespace stillgrid::sim_server
