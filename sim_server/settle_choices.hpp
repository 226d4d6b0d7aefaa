#pragma once

#include <filesystem>

#include "sim_server/bodies/world.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// Chooses the method and the rate that the scene leaves open and logs them. Counted work decides,
/// so that each start chooses the same. Writes the records of a rate into `records`, a line of JSON
/// each, if the path is not empty. world: build_world(scene). Throws std::runtime_error, one line;
/// SegmentError.
void settle_choices(scene::SceneDescription& scene, const bodies::World& world,
                    const std::filesystem::path& records);

/// Prints all candidates of a scene to standard output, with work, error and the reason against
/// each: contacts that were chosen, the method by the spectrum, and rates and methods for a scene
/// with a hand. Writes and throws as settle_choices().
void explain_choices(const scene::SceneDescription& scene, const bodies::World& world,
                     const std::filesystem::path& records);

}  // namespace stillgrid::sim_server
