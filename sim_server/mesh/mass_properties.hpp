#pragma once

#include <Eigen/Core>

#include "sim_server/mesh/triangle_mesh.hpp"

namespace stillgrid::mesh {

/// Volume, centre and inertia of a solid or shell of uniform density, in the mesh's frame.
struct MassProperties {
  double volume_m3 = 0.0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  /// Moments about the centre along the mesh's axes, for a mass of 1 kg.
  Eigen::Matrix3d inertia_per_kg_m2 = Eigen::Matrix3d::Zero();
};

/// The exact integrals over the polyhedron, a tetrahedron from one point to each triangle
/// [Eberly, Polyhedral Mass Properties].
/// Pre: closed, as make_closed() leaves it.
[[nodiscard]] MassProperties mass_properties(const TriangleMesh& closed);

/// Likewise of a thin shell, over its area; its volume is 0. Pre: the mesh has an area.
[[nodiscard]] MassProperties shell_mass_properties(const TriangleMesh& mesh);

/// The area of all triangles together, m^2.
[[nodiscard]] double surface_area_m2(const TriangleMesh& mesh);

}  // namespace stillgrid::mesh
