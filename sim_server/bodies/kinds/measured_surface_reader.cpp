#include "sim_server/bodies/kinds/measured_surface_reader.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "sim_server/fields/stiffness_map.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::bodies {

fields::MeasuredSurface read_measured_surface(toml::TableReader& field,
                                              const Eigen::AlignedBox3d& box_m, Motion motion) {
  fields::MeasuredSurface measured;
  const double near_m = 0.1 * box_m.sizes().maxCoeff();
  if (field.has("offset_m")) {
    measured.offset_m = field.number("offset_m", toml::Bound::kAny);
    if (std::abs(measured.offset_m) > near_m)
      field.refuse("offset_m", "at most a tenth of the mesh's longest side, either way");
    if (motion != Motion::kStatic)
      field.refuse("offset_m", "no such key of a body that moves, for its points lie on its mesh");
  }
  if (!field.has("stiffness_map")) return measured;
  const std::filesystem::path path = field.file("stiffness_map");
  try {
    measured.places = fields::read_stiffness_places(path);
  } catch (const std::runtime_error& error) {
    field.refuse("stiffness_map", std::string("a map of stiffness; ") + error.what());
  }
  const auto strays = std::ranges::count_if(measured.places, [&](const auto& place) {
    return box_m.exteriorDistance(place.position_m) > near_m;
  });
  if (strays > 0)
    field.refuse("stiffness_map", "places of this mesh at this scale; " + std::to_string(strays) +
                                      " of " + std::to_string(measured.places.size()) +
                                      " lie farther from its box than a tenth of its longest side");
  return measured;
}

}  // namespace stillgrid::bodies
