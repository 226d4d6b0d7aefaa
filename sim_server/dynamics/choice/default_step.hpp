#pragma once

#include "sim_server/bodies/world.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::dynamics {

/// Sets rate and method of a scene that names neither: 1 kHz by velocity Verlet. Both stay as they
/// are if such a step is predicted to take more than a quarter of a millisecond. Counts decide, not
/// a clock. world: build_world(scene).
void settle_step(scene::SceneDescription& scene, const bodies::World& world);

}  // namespace stillgrid::dynamics
