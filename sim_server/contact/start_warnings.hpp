#pragma once

#include <string>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::contact {

/// What a scene says that is legal but seldom meant, a line each, `FILE:LINE: body 'NAME': ...`:
/// bodies below a plane, deep overlaps at the start, covers with holes, sizes and speeds that no
/// scene has that a hand feels, places where a snapshot's floats are coarse. Ten lines at most and
/// how many more there are.
///
/// Finds the contacts of the start once: linear in the spheres. Pre: `world` is build_world(scene).
[[nodiscard]] std::vector<std::string> start_warnings(const scene::SceneDescription& scene,
                                                      const bodies::World& world,
                                                      const std::string& file);

}  // namespace stillgrid::contact
