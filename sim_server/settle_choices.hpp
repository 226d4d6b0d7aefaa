#pragma once

#include "sim_server/bodies/world.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// Chooses the method that the scene leaves open and logs it. Counts decide, so that each start
/// chooses the same. world: build_world(scene).
void settle_choices(scene::SceneDescription& scene, const bodies::World& world);

/// Prints to standard output the method by the spectrum and the counts that it follows from.
/// world: build_world(scene).
void explain_choices(const scene::SceneDescription& scene, const bodies::World& world);

}  // namespace stillgrid::sim_server
