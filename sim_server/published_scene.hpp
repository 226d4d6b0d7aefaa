#pragma once

#include "proto/tool_segment.hpp"
#include "shared/publication/scene_segment.hpp"
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

/// The tool as the simulation takes it.
[[nodiscard]] dynamics::ToolSample sample_of(const proto::ToolState& state);

/// The stamps of a hand's snapshot of lockstep.
[[nodiscard]] publication::SnapshotTimes times_of(const ScheduledSnapshot& snapshot,
                                                  const dynamics::StepReport& step,
                                                  std::size_t hand = 0);

}  // namespace stillgrid::sim_server
