#pragma once

#include <functional>
#include <vector>

#include "sim_server/mesh/triangle_mesh.hpp"
#include "sim_server/spheres/ball.hpp"

namespace stillgrid::spheres {

/// Spheres in place of a solid, and how far the two surfaces are apart.
///
/// Distances are upper bounds, not estimates from samples: see decomposition_error.hpp.
struct Decomposition {
  std::vector<Ball> balls;
  double hausdorff_m = 0.0;      // two-sided: the larger of the next two
  double mesh_to_union_m = 0.0;  // no point of the mesh is farther from the union's surface
  double union_to_mesh_m = 0.0;  // no point of the union's surface is farther from the mesh
  double tolerance_m = 0.0;      // that decompose() was asked for
  [[nodiscard]] bool is_reached() const { return hausdorff_m <= tolerance_m; }
};

/// Raised with every change of the spheres that decompose() or sampling.hpp make of a mesh: what
/// was kept before is made anew.
inline constexpr int kDecomposerVersion = 3;

/// Told a step's name and how much of it is done, in [0, 1]. May be empty.
using DecompositionProgress = std::function<void(const char* step, double done)>;

/// Covers a solid with few spheres, to a two-sided Hausdorff distance of at most tolerance_m
/// between the mesh and the surface of the union of spheres.
///
/// Candidates are maximal inscribed balls [Ma, Bae and Choi, The Visual Computer 28, 2012], grown
/// by up to the tolerance, so that a sphere sticks out as far as the gap beside it is deep: that
/// takes about 1/sqrt(2) as many as balls kept inside. They are chosen greedily, then thinned by a
/// local search. The same input gives the same spheres. Takes seconds at 1 % of the box's size.
/// Work is bounded by counts, to minutes: where they do not suffice, as where a mesh cuts itself,
/// the result is what was reached, and its hausdorff_m, true all the same, is more than
/// tolerance_m. Throws std::invalid_argument if tolerance_m is below 1/5000 of the box's diagonal
/// or no number; StopRequested. Pre: closed, as make_closed() leaves it.
[[nodiscard]] Decomposition decompose(const mesh::TriangleMesh& closed, double tolerance_m,
                                      const DecompositionProgress& progress = {});

}  // namespace stillgrid::spheres
