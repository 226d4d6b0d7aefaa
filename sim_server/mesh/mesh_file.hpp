#pragma once

#include <filesystem>
#include <stdexcept>

#include "sim_server/mesh/triangle_mesh.hpp"

namespace stillgrid::mesh {

/// A mesh that cannot be used: one line with its name, what was found with counts, what was
/// expected.
class MeshError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads the triangles of an OBJ, OFF, STL or PLY file, named so; faces of more corners are cut
/// into triangles, all parts become one mesh. The file's coordinates times `scale` are metres.
///
/// Nothing is repaired: see make_closed(). Throws MeshError on a file that cannot be read, is
/// larger than 512 MiB, has faces that cannot be cut (polygon_mesh.hpp), no triangle or more than
/// kMaxTriangles, a number that is none, or is larger than a kilometre or smaller than a
/// micrometre after scaling; StopRequested after a stop signal. Takes memory in proportion to the
/// file. Pre: scale > 0 and finite.
[[nodiscard]] TriangleMesh load_mesh(const std::filesystem::path& path, double scale);

}  // namespace stillgrid::mesh
