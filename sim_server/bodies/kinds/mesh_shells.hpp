#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim_server/bodies/kinds/mesh_fields.hpp"

namespace stillgrid::bodies {

/// Covers meshes that bound no solid with spheres on their surfaces, once all bodies of a scene are
/// read and before make_fields(). Their radius is a quarter of that of the tool's smallest sphere,
/// or 1/64 of the box's longest side if that is less. Larger ones cover where it would take more
/// than about 50,000 spheres of a static body, or 5000 of one that moves. Adds a line a body to
/// notes: why, how many, how large.
void cover_shells(std::span<BodyDescription> bodies, const FieldScene& scene,
                  std::vector<std::string>& notes);

}  // namespace stillgrid::bodies
