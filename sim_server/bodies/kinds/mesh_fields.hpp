#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim_server/bodies/kinds/body_description.hpp"

namespace stillgrid::bodies {

/// Makes the fields that meshes asked for, once all bodies of a scene are read, and the points of
/// those that move. A field goes as far out as the largest sphere that may meet it, of the tool
/// or of another body; without a band of its own it is fine as far as the tool's largest sphere
/// reaches. Adds a line to notes for each. Fields that took more than a second are kept for the
/// next time.
///
/// materials_N_per_m: the stiffness of each material of the scene.
///
/// Throws SceneError, at the line where a field is asked for that takes too much, or one whose map
/// is anywhere more than a thousand times as stiff as the body.
void make_fields(std::span<BodyDescription> bodies, std::span<const double> materials_N_per_m,
                 double tool_radius_m, const std::string& file, std::vector<std::string>& notes);

}  // namespace stillgrid::bodies
