#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "sim_server/mesh/triangle_mesh.hpp"

namespace stillgrid::mesh {

/// Most triangles of a mesh: what comes after takes up to a kilobyte for each.
inline constexpr std::size_t kMaxTriangles = 2'000'000;

/// The faces of a mesh file as they stand there: corners of any number, nothing checked but that
/// each may be a vertex's number. In the file's own unit.
struct PolygonMesh {
  static constexpr std::int32_t kNoVertex = -1;

  std::string name;  // for messages
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::int32_t> corners;   // of all faces, one after the other
  std::vector<std::size_t> face_ends;  // into corners, ascending

  /// Each throws MeshError beyond what kMaxTriangles may need, so that a file's memory is bounded
  /// by 300 MB besides its bytes.
  void add_vertex(double x, double y, double z);
  /// A corner as a file names it, from 0; what cannot be a vertex's number becomes kNoVertex.
  void add_corner(std::int64_t vertex);
  void end_face();
};

/// Cuts every face into triangles that cover it once, in the faces' order; faces of fewer than
/// three corners, points and lines, are left out. A convex face becomes a fan round its first
/// corner, another has its ears cut [Meisters, American Mathematical Monthly 82, 1975], seen along
/// its mean normal [Newell]: it may be bent, as long as its outline does not cross itself there.
///
/// Throws MeshError naming the face, from 1: a corner that is no vertex, a vertex that is no number
/// or beyond 1e30, an outline that crosses itself or turns back, concave outlines so long that they
/// take more than some seconds, more than kMaxTriangles.
[[nodiscard]] TriangleMesh cut_into_triangles(PolygonMesh polygons);

}  // namespace stillgrid::mesh
