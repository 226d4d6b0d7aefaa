#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "sim_server/mesh/triangle_mesh.hpp"

namespace stillgrid::mesh {

/// The point of a surface that is nearest to another.
struct NearestPoint {
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  int triangle = -1;                                  // it lies on this one
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // outwards; a face's, or between faces
};

/// Answers where a closed mesh is nearest, and on which side of it a point lies.
///
/// Embree finds the triangles in question, distances are computed in double precision. At an edge
/// or a vertex the normal is the faces' mean weighted by angle, which gives the right sign
/// everywhere [Baerentzen and Aanaes, IEEE TVCG 11(3), 2005].
/// Queries may run in several threads at once; the same mesh and point give the same answer. All,
/// and making it, throw StopRequested after a stop signal: what asks often takes long.
class MeshDistance {
 public:
  /// Pre: closed, as make_closed() leaves it. The mesh is copied.
  explicit MeshDistance(const TriangleMesh& closed);
  ~MeshDistance();
  MeshDistance(MeshDistance&&) noexcept;
  MeshDistance& operator=(MeshDistance&&) noexcept;

  /// Pre: point_m is finite.
  [[nodiscard]] NearestPoint closest(const Eigen::Vector3d& point_m) const;

  /// Distance to the surface, m, negative inside the solid, never outside of the mesh's box. Pre:
  /// point_m is finite.
  [[nodiscard]] double signed_distance_m(const Eigen::Vector3d& point_m) const;

  /// The triangles within search_radius_m of a point, ascending, and some that are a little
  /// farther. Pre: point_m and search_radius_m are finite.
  [[nodiscard]] std::vector<int> triangles_near(const Eigen::Vector3d& point_m,
                                                double search_radius_m) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace stillgrid::mesh
