#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim_server/bodies/kinds/body_description.hpp"

namespace stillgrid::bodies {

/// What else of a scene its fields are made for.
struct FieldScene {
  double least_tool_radius_m = 0.0, largest_tool_radius_m = 0.0;  // of the tools' spheres
  std::vector<double> materials_N_per_m = {};                     // stiffness of each
};

/// Makes the fields that meshes asked for, once all bodies of a scene are read, and the points of
/// those that move. A field without cells of its own has fields::default_cell_m(). A field reaches
/// as far out as the largest sphere that may meet it, of the tool or of another body; without a
/// band of its own it is fine as far as the tool's largest sphere reaches. Adds lines to notes.
/// Fields that took more than a second are kept for the next time.
///
/// Throws SceneError, at the line where a field is asked for that takes too much or whose map is
/// anywhere more than a thousand times as stiff as the body.
void make_fields(std::span<BodyDescription> bodies, const FieldScene& scene,
                 const std::string& file, std::vector<std::string>& notes);

}  // namespace stillgrid::bodies
