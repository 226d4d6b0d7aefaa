#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "sim_server/mesh/mesh_distance.hpp"
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

/// Centre of a tool sphere that is pressed so deep along sample i's normal.
[[nodiscard]] Eigen::Vector3d pressed_tool_m(const SurfaceSamples& surface, std::size_t i,
                                             double tool_radius_m, double press_depth_m);

/// Those samples at which a tool sphere can be pressed press_depth_m deep without being a tenth of
/// that deeper elsewhere: not those in creases narrower than the tool.
/// Pre: the samples are of that mesh, 0 < press_depth_m.
[[nodiscard]] SurfaceSamples reachable_samples(const SurfaceSamples& surface,
                                               const mesh::MeshDistance& mesh, double tool_radius_m,
                                               double press_depth_m);

}  // namespace stillgrid::spheres
