#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <vector>

#include "sim_server/mesh/mesh_repair.hpp"
#include "sim_server/spheres/feel.hpp"
#include "sim_server/spheres/feel_search.hpp"
#include "sim_server/spheres/fineness.hpp"

namespace stillgrid::spheres {

/// How each level feels. Pre: press of that mesh.
[[nodiscard]] std::vector<Feel> feels_of(std::span<const Decomposition> levels,
                                         const mesh::TriangleMesh& closed, const Press& press);

/// A report of sphere_decompose, see docs/formats.md, but for the names of files: what was read,
/// repaired and asked for; count, errors and force of each level; what it took. feels: of each
/// level.
[[nodiscard]] nlohmann::json report_fields(const mesh::TriangleMesh& read,
                                           const mesh::ClosedMesh& closed, const Fineness& fineness,
                                           std::span<const Decomposition> levels,
                                           std::span<const Feel> feels, const Press& press,
                                           double time_s);

/// What a search by feel asked for, and its levels from coarse to fine.
[[nodiscard]] nlohmann::json search_fields(double share, std::span<const FeltLevel> levels);

}  // namespace stillgrid::spheres
