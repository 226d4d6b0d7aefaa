#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

namespace stillgrid::mesh {

/// A surface of triangles. Lengths in metres, in the mesh's own frame.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices_m;
  std::vector<Eigen::Vector3i> triangles;  // counter-clockwise seen from outside
};

/// Of all vertices; empty where there is none. In the mesh's own frame.
[[nodiscard]] inline Eigen::AlignedBox3d box_of(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex_m : mesh.vertices_m) box.extend(vertex_m);
  return box;
}

}  // namespace stillgrid::mesh
