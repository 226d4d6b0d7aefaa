#pragma once

#include <string>

#include "sim_server/bodies/world.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// A few lines for people: what a scene holds, who touches it, how often and by which method it
/// would be stepped, and which of these was chosen. Pre: world is build_world(scene), and what the
/// scene leaves to choose is chosen.
[[nodiscard]] std::string summary_of(const scene::SceneDescription& scene,
                                     const bodies::World& world);

}  // namespace stillgrid::sim_server
