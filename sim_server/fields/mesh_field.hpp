#pragma once

#include "shared/collision/distance_field.hpp"
#include "sim_server/fields/measured_surface.hpp"
#include "sim_server/mesh/triangle_mesh.hpp"

namespace stillgrid::fields {

/// About the most bytes that a field takes whose cells are default_cell_m() wide.
inline constexpr double kDefaultFieldBytes = 16.0 * 1048576.0;

/// Returns the default edge of a field's cells, m. It is the least of half the radius of the tool's
/// smallest sphere, half the mean thickness 2 volume / area, and 1/32 of the box's longest side.
/// Wider cells where the field would take more than about kDefaultFieldBytes
/// with that band and margin. Follows from lengths alone, so that each machine gets the same.
/// Pre: closed, as make_closed() leaves it; tool_radius_m, band_m, margin_m > 0.
[[nodiscard]] double default_cell_m(const mesh::TriangleMesh& closed, double tool_radius_m,
                                    double band_m, double margin_m);

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
