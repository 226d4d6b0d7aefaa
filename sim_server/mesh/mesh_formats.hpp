#pragma once

#include <string>
#include <string_view>

#include "sim_server/mesh/polygon_mesh.hpp"

namespace stillgrid::mesh {

/// Readers of mesh files: the bytes of one, and its name for messages.
///
/// Each throws MeshError, one line with the place, on what is not its format, and takes time and
/// memory by what the bytes hold, whatever they declare (polygon_mesh.hpp has the limits). Faces,
/// and nothing else that a file may hold beside them, are kept. StopRequested ends them.

/// Wavefront OBJ: v and f; all groups and objects together.
[[nodiscard]] PolygonMesh read_obj(std::string_view bytes, const std::string& name);
/// Geomview OFF as text, with or without colours, normals and the first word; a vertex or a face a
/// line.
[[nodiscard]] PolygonMesh read_off(std::string_view bytes, const std::string& name);
/// STL, binary or text; all solids together. Corners are not joined.
[[nodiscard]] PolygonMesh read_stl(std::string_view bytes, const std::string& name);
/// PLY 1.0, text or binary of either order; of its elements vertex and face.
[[nodiscard]] PolygonMesh read_ply(std::string_view bytes, const std::string& name);

}  // namespace stillgrid::mesh
