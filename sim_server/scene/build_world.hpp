#pragma once

#include "sim_server/bodies/world.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::scene {

/// Lays out bodies, springs and spheres as the scene says. Pre: the scene was checked by
/// load_scene().
[[nodiscard]] bodies::World build_world(const SceneDescription& scene);

}  // namespace stillgrid::scene
