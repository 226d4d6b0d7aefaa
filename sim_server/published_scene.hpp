#pragma once

#include <optional>
#include <vector>

#include "proto/tool_segment.hpp"
#include "shared/publication/session.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/lockstep_schedule.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// Returns the fixed part of the first hand's segment. If another process can step the scene in a
/// tick of its hand, it has the model that continues from the states of snapshots. Such a scene has
/// ticks of 1 ms, and a period has one at least.
[[nodiscard]] publication::StaticScene static_scene(const scene::SceneDescription& scene,
                                                    const dynamics::Simulation& simulation);

/// Returns the fixed parts of the segments of all hands.
[[nodiscard]] std::vector<publication::HandScene> hand_scenes(
    const scene::SceneDescription& scene, const dynamics::Simulation& simulation);

/// The tool as the simulation takes it.
[[nodiscard]] std::optional<dynamics::ToolSample> sample_of(
    const std::optional<proto::ToolState>& state);

/// The stamps of a hand's snapshot of lockstep.
[[nodiscard]] publication::SnapshotTimes times_of(const ScheduledSnapshot& snapshot,
                                                  const dynamics::StepReport& step,
                                                  std::size_t hand = 0);

}  // namespace stillgrid::sim_server
