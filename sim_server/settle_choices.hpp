#pragma once

#include <filesystem>

#include "sim_server/bodies/world.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// Where a choice is read from and kept.
struct ChoiceFiles {
  std::filesystem::path scene;
  std::filesystem::path record = {};  // none: nothing is read or written
};

/// Sets what the scene leaves to us, method and rate: as recorded, or else chosen within seconds,
/// and told in the log. In virtual time only a record serves: there no clock may decide.
/// world: build_world(scene). Throws std::runtime_error, one line; RecordError; SegmentError.
void settle_choices(scene::SceneDescription& scene, const bodies::World& world,
                    const ChoiceFiles& files, bool is_virtual);

/// Prints to standard output what each method would cost and err, and of a scene with a hand what
/// each rate would; writes the record, if there is one. Throws as settle_choices().
void explain_choices(scene::SceneDescription scene, const bodies::World& world,
                     const ChoiceFiles& files);

}  // namespace stillgrid::sim_server
