#pragma once

#include <cstddef>
#include <vector>

#include "sim_server/mesh/triangle_mesh.hpp"
#include "sim_server/spheres/ball.hpp"

namespace stillgrid::fields {

/// Points of a closed surface by which its solid meets planes and the fields of others [Barbic and
/// James 2008], as small balls that each touch the surface from inside at their point, or where it
/// is too sharp for that lie about it.
///
/// Convex corners come first, the sharpest before others, then points along convex edges, then
/// evenly strewn ones: any two whose normals do not oppose are a spacing apart, and none of the
/// surface is much farther than that from one. Points on either side of a thin part do not crowd
/// each other out. The spacing is such that a solid which is nowhere thinner than it has at most
/// `most` of them. The same points on every call.
///
/// Throws StopRequested after a stop signal. Pre: closed, as make_closed() leaves it; most > 0.
[[nodiscard]] std::vector<spheres::Ball> surface_points(const mesh::TriangleMesh& closed,
                                                        std::size_t most);

}  // namespace stillgrid::fields
