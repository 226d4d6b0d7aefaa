#pragma once

#include <optional>
#include <vector>

#include "proto/tool_segment.hpp"
#include "shared/publication/session.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/lockstep_schedule.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// Iterations of a step, on any clock: more than the parts of a step that converges have together.
inline constexpr int kMaxIterations = 1000;

/// What is published of a scene for one of its hands, once, before its first snapshot.
[[nodiscard]] publication::StaticScene static_scene(const scene::SceneDescription& scene,
                                                    const dynamics::Simulation& simulation,
                                                    std::size_t hand = 0);

/// Of all its hands.
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
