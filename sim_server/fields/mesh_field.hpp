#pragma once

#include "shared/collision/distance_field.hpp"
#include "sim_server/mesh/triangle_mesh.hpp"

namespace stillgrid::fields {

/// Changes whenever the same mesh would get another field.
inline constexpr int kFieldVersion = 1;

/// The field of the solid that a mesh bounds, in the mesh's frame, by its exact distance
/// (mesh/mesh_distance.hpp). The same mesh gives the same field, to the bit.
///
/// Throws std::invalid_argument where it would take more than collision::kMaxFieldBytes, and
/// StopRequested after a stop signal, for it may take long.
/// Pre: closed, as make_closed() leaves it; all of `fineness` > 0.
[[nodiscard]] collision::DistanceField make_mesh_field(const mesh::TriangleMesh& closed,
                                                       const collision::FieldFineness& fineness);

}  // namespace stillgrid::fields
