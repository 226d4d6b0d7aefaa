#pragma once

#include <filesystem>

#include "sim_server/bodies/world.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// Files of a choice.
struct ChoiceFiles {
  std::filesystem::path scene;
  std::filesystem::path record = {};  // none: nothing is read or written
};

/// Chooses the method and the rate that the scene leaves open, within seconds, and logs them. A
/// rate depends on a clock, so it is read from the record if there is one, and in virtual time it
/// must be. world: build_world(scene). Throws std::runtime_error, one line; RecordError;
/// SegmentError.
void settle_choices(scene::SceneDescription& scene, const bodies::World& world,
                    const ChoiceFiles& files, bool is_virtual);

/// Prints cost and error of each method to standard output, and of each rate for a scene with a
/// hand; then writes the record of the rate, if a file is named. Throws as settle_choices().
void explain_choices(scene::SceneDescription scene, const bodies::World& world,
                     const ChoiceFiles& files);

}  // namespace stillgrid::sim_server
