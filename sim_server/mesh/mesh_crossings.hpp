#pragma once

#include <span>
#include <string>

#include "sim_server/mesh/triangle_mesh.hpp"

namespace stillgrid::mesh {

/// How many edges pass through a face that shares no corner with them; each edge once per face. Of
/// two pieces only the inside of a face counts: they may touch at their edges.
struct Crossings {
  int within_pieces = 0;
  int between_pieces = 0;
};

/// Throws MeshError where so many faces lie near each edge that asking would take more than some
/// seconds; StopRequested.
/// Pre: the triangles' indices are valid; piece_of_face numbers the piece of each.
[[nodiscard]] Crossings count_crossings(const TriangleMesh& mesh,
                                        std::span<const int> piece_of_face,
                                        const std::string& name);

}  // namespace stillgrid::mesh
