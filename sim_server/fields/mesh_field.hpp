#pragma once

#include "shared/collision/distance_field.hpp"
#include "sim_server/fields/measured_surface.hpp"
#include "sim_server/mesh/triangle_mesh.hpp"

namespace stillgrid::fields {

/// Changes whenever the same mesh would get another field.
inline constexpr int kFieldVersion = 1;

/// The field of the solid that a mesh bounds, in the mesh's frame, by its exact distance
/// (mesh/mesh_distance.hpp), less the offset of its measured surface; its stiffness is the map's
/// at the nearest point of the mesh, over the body's own. The same mesh and measurement give the
/// same field, to the bit.
///
/// Throws std::invalid_argument where it would take more than collision::kMaxFieldBytes or is
/// anywhere more than a thousand times as stiff as the body, and StopRequested after a stop signal,
/// for it may take long. Pre: closed, as make_closed() leaves it; all of `fineness` > 0.
[[nodiscard]] collision::DistanceField make_mesh_field(const mesh::TriangleMesh& closed,
                                                       const collision::FieldFineness& fineness,
                                                       const MeasuredSurface& measured = {});

}  // namespace stillgrid::fields
