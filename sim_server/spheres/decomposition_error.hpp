#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "sim_server/mesh/mesh_distance.hpp"
#include "sim_server/spheres/ball.hpp"
#include "sim_server/spheres/decomposition.hpp"
#include "sim_server/spheres/surface_samples.hpp"

namespace stillgrid::spheres {

/// A solid, and what its spheres' distances are bounded with.
struct MeshSolid {
  mesh::TriangleMesh mesh;
  mesh::MeshDistance distance;
  double size_m = 0.0;       // diagonal of the box
  bool cuts_itself = false;  // then its normals may take outside for inside

  /// Pre: closed, as make_closed() leaves it.
  explicit MeshSolid(const mesh::TriangleMesh& closed);
};

/// Places where spheres and mesh are farther apart than a limit.
struct TooFar {
  SurfaceSamples uncovered;                // on the mesh, outside all balls
  std::vector<Eigen::Vector3d> filled_m;   // on the mesh, in crevices that balls fill
  std::vector<Eigen::Vector3d> hollows_m;  // on the union's surface, deep inside the solid
  std::size_t patches = 0;                 // that were looked at
  [[nodiscard]] bool none() const {
    return uncovered.points_m.empty() && filled_m.empty() && hollows_m.empty();
  }
};

/// Looks for such places, patch by patch; a patch is given up below spacing_m. Places that are
/// missed are no farther than limit_m + spacing_m, unless 200,000 were found before.
[[nodiscard]] TooFar find_too_far(const MeshSolid& solid, std::span<const Ball> balls,
                                  double limit_m, double spacing_m);

/// The decomposition that these balls are, with upper bounds of its two distances that exceed them
/// by at most precision_m, but at narrow crevices that balls fill, where the first is larger, and
/// where millions of patches do not suffice.
///
/// Triangles and spheres are cut into patches, the worst first, until the bound is that near to a
/// distance found. On the mesh, outside the union: a distance from a ball is convex, so largest at
/// a patch's corners. Inside the union: a way out of it, along a direction. On the union: the
/// distance to the mesh changes by no more than one walks. Where a mesh cuts itself, so that
/// normals may take outside for inside, the last is a bound to within half of what a ball sticks
/// out. Pre: balls not empty, precision_m > 0.
[[nodiscard]] Decomposition with_error(const MeshSolid& solid, std::vector<Ball> balls,
                                       double precision_m);

}  // namespace stillgrid::spheres
