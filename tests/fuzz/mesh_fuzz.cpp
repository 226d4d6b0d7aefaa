#include <cstdint>
#include <string>
#include <string_view>

#include "sim_server/mesh/mesh_file.hpp"
#include "sim_server/mesh/mesh_formats.hpp"
#include "sim_server/mesh/mesh_repair.hpp"
#include "tests/fuzz/fuzz_input.hpp"

/// A mesh file of others: it becomes triangles and perhaps a closed surface, or is refused in one
/// line that begins with its name.
///
/// Input: the format u8 (OBJ, OFF, STL, PLY), then the file.
namespace stillgrid::fuzz {
namespace {

void check_triangles(const mesh::TriangleMesh& mesh) {
  const auto count = static_cast<int>(mesh.vertices_m.size());
  for (const Eigen::Vector3i& triangle : mesh.triangles)
    require(triangle.minCoeff() >= 0 && triangle.maxCoeff() < count, "a corner is a vertex");
  for (const Eigen::Vector3d& vertex : mesh.vertices_m)
    require(vertex.allFinite(), "a vertex is a place");
}

void read(unsigned format, std::string_view bytes) {
  constexpr mesh::PolygonMesh (*kReaders[])(std::string_view, const std::string&) = {
      mesh::read_obj, mesh::read_off, mesh::read_stl, mesh::read_ply};
  const std::string name = "fuzz";
  try {
    const mesh::TriangleMesh mesh = mesh::cut_into_triangles(kReaders[format % 4](bytes, name));
    check_triangles(mesh);
    check_triangles(mesh::make_closed(mesh, name).mesh);
  } catch (const mesh::MeshError& refusal) {
    const std::string_view line = refusal.what();
    require(line.starts_with(name + ":"), "a refusal names the file");
    require(line.find_first_of("\n\r") == std::string_view::npos, "a refusal is one line");
  }
}

}  // namespace
}  // namespace stillgrid::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  stillgrid::fuzz::read(data[0], bytes);
  return 0;
}
