#pragma once

#include "proto/tool_segment.hpp"
#include "shared/publication/scene_segment.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/lockstep_schedule.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid {

/// Iterations of a step, on any clock: more than the parts of a step that converges have together.
inline constexpr int kMostIterations = 1000;

/// What is published of a scene once, before its first image.
[[nodiscard]] StaticScene static_scene(const SceneDescription& scene, const Simulation& simulation);

/// The tool as the simulation takes it.
[[nodiscard]] ToolSample sample_of(const proto::ToolState& state);

/// The stamps of an image of lockstep.
[[nodiscard]] ImageTimes times_of(const ScheduledImage& image, const StepReport& step);

}  // namespace stillgrid
