#pragma once

#include <Eigen/Core>
#include <vector>

namespace stillgrid::mesh {

/// A surface of triangles. Lengths in metres, in the mesh's own frame.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices_m;
  std::vector<Eigen::Vector3i> triangles;  // counter-clockwise seen from outside
};

}  // namespace stillgrid::mesh
