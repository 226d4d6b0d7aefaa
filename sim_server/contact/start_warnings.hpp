#pragma once

#include <string>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::contact {

/// Returns a line for each value that is legal but seldom meant, `FILE:LINE: body 'NAME': ...`:
/// bodies below a plane, deep overlaps at the start, covers with holes, sizes, speeds and masses
/// that no scene has that a hand feels, places where a snapshot's floats are coarse; without a line
/// number materials and tools that no hand feels or holds. Ten lines at most and how many more
/// there are.
///
/// Finds the contacts of the start once: linear in the spheres. Pre: `world` is build_world(scene).
[[nodiscard]] std::vector<std::string> start_warnings(const scene::SceneDescription& scene,
                                                      const bodies::World& world,
                                                      const std::string& file);

/// Returns at most ten lines, one for each cover whose spacing is greater than its radius.
[[nodiscard]] std::vector<std::string> cover_warnings(const scene::SceneDescription& scene,
                                                      const std::string& file);

}  // namespace stillgrid::contact
