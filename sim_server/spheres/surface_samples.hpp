#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "sim_server/mesh/triangle_mesh.hpp"

namespace stillgrid::spheres {

/// Points spread evenly over a surface, each standing for the same area. Lengths in metres, in the
/// body's own frame.
struct SurfaceSamples {
  std::vector<Eigen::Vector3d> points_m;
  std::vector<Eigen::Vector3d> normals;  // unit, out of the solid; as many as points_m
};

/// Spreads count points over a mesh by area: point i lies where the area summed over the triangles
/// reaches (i + 1/2) / count of the whole, its place within that triangle from an additive
/// recurrence of low discrepancy, its normal the triangle's. The same points on every call.
///
/// Pre: the mesh has an area, count > 0.
[[nodiscard]] SurfaceSamples sample_surface(const mesh::TriangleMesh& mesh, std::size_t count);

}  // namespace stillgrid::spheres
