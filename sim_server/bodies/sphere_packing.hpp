#pragma once

#include <vector>

#include "sim_server/bodies/world.hpp"

namespace stillgrid {

/// Covers a body with spheres by its parameters [Davanne 2002, "Interaction model", second method]:
/// a thread along its curve, a sheet over its surface, a box through its volume, a sphere with
/// itself, a plane with none. A mesh has its balls.
///
/// body.spheres chooses spacing and radius; where it does not, a thread or sheet gets a sphere a
/// node with radius 0.75 of the spacing, a box three spheres along its shortest edge. A soft
/// solid's spheres hang on the four nodes round them that bind_to_lattice() names. Nodes are
/// numbered from 0 within the body; rest positions are in the world.
[[nodiscard]] std::vector<SphereBinding> pack_spheres(const BodyDescription& body);

/// The spheres of a sheet along its x and y; they are numbered x fastest.
[[nodiscard]] Eigen::Vector2i sheet_spheres(const BodyDescription& body);

/// How many spheres that makes, without making them; a double, for it may exceed every integer.
[[nodiscard]] double sphere_count(const BodyDescription& body);

}  // namespace stillgrid
