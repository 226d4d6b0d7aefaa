#pragma once

#include <filesystem>
#include <stdexcept>

#include "sim_server/mesh/polygon_mesh.hpp"
#include "sim_server/mesh/triangle_mesh.hpp"

namespace stillgrid::mesh {

/// A mesh that cannot be used: one line with its name, what was found with counts, what was
/// expected.
class MeshError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A surface with an area that bounds no solid: it may still be felt as a thin shell.
class NotSolid : public MeshError {
 public:
  using MeshError::MeshError;
};

/// The triangles of a mesh as it came, its coordinates times `scale` metres.
///
/// Nothing is repaired: see make_closed(). Throws MeshError as cut_into_triangles(), and for no
/// triangle or a mesh that is larger than a kilometre or smaller than a micrometre after scaling.
/// Pre: scale > 0 and finite.
[[nodiscard]] TriangleMesh sized_mesh(PolygonMesh polygons, double scale);

/// Reads the triangles of an OBJ, OFF, STL or PLY file, named so; faces of more corners are cut
/// into triangles, all parts become one mesh. The file's coordinates times `scale` are metres.
///
/// Throws MeshError as sized_mesh(), and on a file that cannot be read or is larger than 512 MiB;
/// StopRequested after a stop signal. Takes memory in proportion to the file.
/// Pre: scale > 0 and finite.
[[nodiscard]] TriangleMesh load_mesh(const std::filesystem::path& path, double scale);

}  // namespace stillgrid::mesh
