#pragma once

#include <string>

#include "haptic_server/recording/scene_sample.hpp"
#include "haptic_server/recording/tick_row.hpp"

namespace stillgrid::recording {

/// Messages of an MCAP recording as JSON: docs/formats.md, "MCAP". What is no number is left out.

/// stillgrid.Tick: all of a row but the pose.
void write_tick(const TickRow& row, std::string& json);

/// stillgrid.Flags: each flag, whether it is set.
void write_flags(std::uint32_t flags, std::string& json);

/// foxglove.FrameTransform of frame "tool" in frame "scene". time_ns: since 1970, or of the run.
void write_pose(const TickRow& row, std::uint64_t time_ns, std::string& json);

/// foxglove.SceneUpdate: an entity a body, in place of all that were shown before on its topic.
void write_spheres(const SampledSpheres& sampled, std::uint64_t time_ns, std::string& json);

/// The same of what never moves: spheres, and planes as squares.
void write_fixed(const FixedScene& scene, std::uint64_t time_ns, std::string& json);

/// The tool's spheres, in its frame.
void write_tool(const std::vector<proto::ToolSphere>& tool, std::uint64_t time_ns,
                std::string& json);

}  // namespace stillgrid::recording
