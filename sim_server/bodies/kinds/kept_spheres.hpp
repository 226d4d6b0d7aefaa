#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim_server/bodies/kinds/body_description.hpp"
#include "sim_server/spheres/sphere_cache.hpp"

namespace stillgrid::bodies {

/// The spheres of a body's mesh that were made before, or those that `make` makes; what took long
/// is kept for the next time. Adds a line to notes. Throws as `make`.
[[nodiscard]] std::vector<spheres::Ball> made_or_kept(
    const spheres::SphereCache& cache, const BodyDescription& body, std::vector<std::string>& notes,
    const std::function<spheres::Decomposition()>& make);

}  // namespace stillgrid::bodies
