#pragma once

#include <string_view>

#include "sim_server/mesh/mesh_holes.hpp"
#include "sim_server/mesh/triangle_mesh.hpp"

namespace stillgrid::mesh {

/// What make_closed() changed.
struct MeshRepair {
  int welded_vertices = 0;    // joined with another within a millionth of the box
  int degenerate_faces = 0;   // dropped: a corner twice
  int doubled_faces = 0;      // dropped: the three corners of another face
  int turned_faces = 0;       // they faced the other way than their neighbours
  int turned_components = 0;  // whole pieces that were inside out
  int split_vertices = 0;     // where pieces touched in one point
  ClosedHoles holes = {};
};

/// A surface that bounds a solid: every edge joins two triangles, all face outwards.
struct ClosedMesh {
  TriangleMesh mesh;
  MeshRepair repair;
  int components = 0;  // separate pieces of surface
  /// Edges that pierce a face of their own piece: small folds, where the inside is in doubt.
  int folds = 0;
};

/// Repairs what is certain, so that inside and outside are defined; `name` is for messages.
///
/// Joins coincident vertices, drops degenerate and doubled faces, turns faces and pieces that face
/// the wrong way, closes small holes. A piece within another that faces the other way is a cavity
/// and stays one. Throws MeshError naming reason and counts: no triangles, a number that is none;
/// NotSolid: open (edges of one face), not manifold (edges of three or more), not orientable,
/// pieces without volume, a piece within another that faces the same way, pieces that cut one
/// another.
[[nodiscard]] ClosedMesh make_closed(TriangleMesh mesh, std::string_view name);

}  // namespace stillgrid::mesh
