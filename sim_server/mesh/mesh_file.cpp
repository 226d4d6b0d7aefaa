#include "sim_server/mesh/mesh_file.hpp"

#include <Eigen/Geometry>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>

#include "shared/files/text_file.hpp"
#include "shared/realtime/stop_signal.hpp"
#include "sim_server/mesh/mesh_formats.hpp"

namespace stillgrid::mesh {
namespace {

constexpr std::uintmax_t kMaxBytes = 512 * files::kMiB;

using Reader = PolygonMesh (*)(std::string_view, const std::string&);

Reader reader_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const auto& [known, reader] : {std::pair<const char*, Reader>{".obj", read_obj},
                                      {".off", read_off},
                                      {".stl", read_stl},
                                      {".ply", read_ply}})
    if (extension == known) return reader;
  throw MeshError(path.string() + ": is named like no mesh: expected .obj, .off, .stl or .ply");
}

/// Reads a regular file in pieces, between which a stop is heeded.
std::string bytes_of(const std::filesystem::path& path) {
  const std::string name = path.string();
  try {
    files::require_regular(path, kMaxBytes);
  } catch (const std::runtime_error& refusal) {
    throw MeshError(refusal.what());
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) throw MeshError(name + ": cannot be read: " + std::strerror(errno));
  constexpr std::size_t kPiece = 1U << 20U;
  std::string bytes;
  while (file) {
    realtime::throw_if_stopped();
    const std::size_t before = bytes.size();
    bytes.resize(before + kPiece);
    file.read(bytes.data() + before, kPiece);
    bytes.resize(before + static_cast<std::size_t>(file.gcount()));
  }
  if (file.bad()) throw MeshError(name + ": could not be read to its end");
  return bytes;
}

void check_size(const TriangleMesh& mesh, const std::string& name) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3i& triangle : mesh.triangles)
    for (const int vertex : triangle) box.extend(mesh.vertices_m[static_cast<std::size_t>(vertex)]);
  constexpr double kLeast_m = 1e-6, kMax_m = 1e3;
  const double size_m = box.sizes().maxCoeff();
  const double farthest_m = box.max().cwiseAbs().cwiseMax(box.min().cwiseAbs()).maxCoeff();
  std::ostringstream value;
  if (size_m < kLeast_m || size_m > kMax_m)
    value << ": longest side of the box: value " << size_m;
  else if (farthest_m > kMax_m)
    value << ": farthest coordinate: value " << farthest_m;
  else
    return;
  throw MeshError(name + value.str() + " m after scaling: expected 1e-6 to 1000 m; see the scale");
}

}  // namespace

TriangleMesh sized_mesh(PolygonMesh polygons, double scale) {
  const std::string name = polygons.name;
  TriangleMesh mesh = cut_into_triangles(std::move(polygons));
  if (mesh.triangles.empty())
    throw MeshError(name + ": 0 triangles of " + std::to_string(mesh.vertices_m.size()) +
                    " vertices: expected a surface");
  for (Eigen::Vector3d& vertex : mesh.vertices_m) vertex *= scale;
  check_size(mesh, name);
  return mesh;
}

TriangleMesh load_mesh(const std::filesystem::path& path, double scale) {
  const std::string name = path.string();
  if (!std::filesystem::exists(path)) throw MeshError(name + ": no such file");
  if (std::filesystem::is_directory(path))
    throw MeshError(name + ": is a folder: expected a mesh (OBJ, OFF, STL or PLY)");
  const Reader read = reader_of(path);
  return sized_mesh(read(bytes_of(path), name), scale);
}

}  // namespace stillgrid::mesh
