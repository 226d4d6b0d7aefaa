#pragma once

#include <span>
#include <vector>

#include "sim_server/mesh/mesh_distance.hpp"
#include "sim_server/spheres/force_map.hpp"

namespace stillgrid::fields {

/// What a solid of 1 N/m should do to a tool sphere, still: as deep as it is in the mesh, out along
/// the shortest way. In N for each N/m, that is in metres. Pre: tool_m is finite.
[[nodiscard]] Eigen::Vector3d exact_force_m(const mesh::MeshDistance& mesh,
                                            const Eigen::Vector3d& tool_m, double tool_radius_m);

/// Where a tool's sphere is pressed into a mesh, and the exact force there.
struct PressedPlaces {
  double tool_radius_m = 0.0;
  std::vector<Eigen::Vector3d> tool_m, force_m;
};

/// The reachable ones of so many samples of the surface (spheres::reachable_samples()), each
/// pressed along its normal to every one of the depths. Pre: closed; count > 0; depths > 0, less
/// than the radius.
[[nodiscard]] PressedPlaces press_everywhere(const mesh::TriangleMesh& closed,
                                             const mesh::MeshDistance& distance, std::size_t count,
                                             double tool_radius_m,
                                             std::span<const double> depths_m);

/// How far a model's force is from the exact one over those places: rms of the difference over rms
/// of the exact force; over rendering::kJustNoticeable it is in just noticeable differences.
/// Pre: there are places.
[[nodiscard]] double force_error_share(const PressedPlaces& places,
                                       const spheres::UnitForce& force);

}  // namespace stillgrid::fields
