#pragma once

#include <nlohmann/json_fwd.hpp>

#include "sim_server/mesh/mesh_repair.hpp"
#include "sim_server/spheres/fineness.hpp"

namespace stillgrid::spheres {

/// Returns a report of sphere_decompose, see docs/formats.md, but for the names of files: the mesh
/// as read and repaired, the fineness asked for, the number of spheres, distances and time.
[[nodiscard]] nlohmann::json report_fields(const mesh::TriangleMesh& read,
                                           const mesh::ClosedMesh& closed, const Fineness& fineness,
                                           const Decomposition& made, double time_s);

}  // namespace stillgrid::spheres
