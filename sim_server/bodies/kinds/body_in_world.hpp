#pragma once

#include <span>
#include <vector>

#include "sim_server/bodies/kinds/body_description.hpp"
#include "sim_server/bodies/surfaces.hpp"
#include "sim_server/bodies/world.hpp"

namespace stillgrid::bodies {

/// Covers a body with spheres by its parameters [Davanne 2002, "Interaction model", second method]:
/// a thread along its curve, a sheet over its surface, a box through its volume, a sphere with
/// itself, a plane with none. A mesh has its balls; with a field, points of its surface, and none
/// where it never moves.
///
/// Its SpherePacking chooses spacing and radius; where it does not, a thread or sheet gets a sphere
/// a node with radius 0.75 of the spacing, a box three spheres along its shortest edge. A soft
/// solid's spheres hang on the four nodes round them that bind_to_lattice() names. Nodes are
/// numbered from 0 within the body; rest positions are in the world.
[[nodiscard]] std::vector<SphereBinding> pack_spheres(const BodyDescription& body);

/// What the body amounts to, without making it.
[[nodiscard]] BodyCounts counts_of(const BodyDescription& body);

/// The nodes and springs of a deformable body where it stands at rest; none of others.
[[nodiscard]] SpringNet spring_net_of(const BodyDescription& body);

/// Appends a body's nodes, springs, rigid body, spheres, field or plane to a world. Its number is
/// the count of bodies before it. Pre: its material is there.
void add_body(World& world, const BodyDescription& body);

/// The surfaces of a world that was just built from these bodies: of a sheet the grid of its
/// spheres, of a thread the line through them, of a box its faces, of a soft block its lattice's
/// skin, of a mesh its triangles. Planes and spheres have none, nor has a box or a mesh whose
/// spheres span no space, such as one row or one layer of them.
[[nodiscard]] std::vector<BodySurface> rest_surfaces(std::span<const BodyDescription> bodies,
                                                     const World& world);

}  // namespace stillgrid::bodies
