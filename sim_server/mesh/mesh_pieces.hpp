#pragma once

#include <span>
#include <string>

#include "sim_server/mesh/triangle_mesh.hpp"

namespace stillgrid::mesh {

/// Most separate pieces of a mesh: each is compared with every other.
inline constexpr int kMaxPieces = 10'000;

/// Turns the pieces that are inside out, so that each faces out and a cavity faces in. Returns how
/// many. piece_of_face numbers the piece of each face, from 0.
///
/// Throws NotSolid on a piece without volume, one that lies within another and faces the same way,
/// more than kMaxPieces; StopRequested.
/// Pre: every edge joins two faces that agree; pieces do not cut one another.
int turn_pieces(TriangleMesh& mesh, std::span<const int> piece_of_face, int count,
                const std::string& name);

}  // namespace stillgrid::mesh
