#include <bit>
#include <cstring>

#include "sim_server/mesh/mesh_formats.hpp"
#include "sim_server/mesh/mesh_text.hpp"

namespace stillgrid::mesh {
namespace {

constexpr std::size_t kHeaderBytes = 84, kCountAt = 80, kTriangleBytes = 50, kNormalBytes = 12;
static_assert(std::endian::native == std::endian::little, "binary STL is little-endian");

PolygonMesh read_binary(std::string_view bytes, std::uint32_t triangles, const std::string& name) {
  PolygonMesh mesh{name, {}, {}, {}};
  for (std::uint32_t i = 0; i < triangles; ++i) {
    realtime::throw_if_stopped();
    const char* at = bytes.data() + kHeaderBytes + i * kTriangleBytes + kNormalBytes;
    for (int k = 0; k < 3; ++k) {
      float place[3];
      std::memcpy(place, at + k * static_cast<int>(sizeof place), sizeof place);
      mesh.add_corner(static_cast<std::int64_t>(mesh.vertices.size()));
      mesh.add_vertex(place[0], place[1], place[2]);
    }
    mesh.end_face();
  }
  return mesh;
}

PolygonMesh read_text(std::string_view bytes, const std::string& name) {
  MeshText text(bytes, name);
  PolygonMesh mesh{name, {}, {}, {}};
  bool is_open = false;
  while (text.next_line()) {
    const std::string_view key = text.word();
    if (key == "vertex") {
      const double x = text.number("vertex"), y = text.number("vertex"), z = text.number("vertex");
      if (!is_open) text.refuse("vertex: outside of a loop: expected 'outer loop' before it");
      mesh.add_corner(static_cast<std::int64_t>(mesh.vertices.size()));
      mesh.add_vertex(x, y, z);
    } else if (key == "outer" || key == "endloop") {
      if (is_open == (key == "outer"))
        text.refuse(std::string(key) + ": expected each outer loop to end before the next");
      if (is_open) mesh.end_face();
      is_open = !is_open;
    }
  }
  if (is_open) text.refuse("ends within a loop: expected endloop");
  return mesh;
}

}  // namespace

PolygonMesh read_stl(std::string_view bytes, const std::string& name) {
  std::uint32_t triangles = 0;
  std::size_t wanted = 0;
  if (bytes.size() >= kHeaderBytes) {
    std::memcpy(&triangles, bytes.data() + kCountAt, sizeof triangles);
    wanted = kHeaderBytes + kTriangleBytes * std::size_t{triangles};
  }
  // Binary files may begin with "solid" too, so their size is asked first.
  if (wanted > 0 && bytes.size() == wanted) return read_binary(bytes, triangles, name);
  const std::size_t first = bytes.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && bytes.substr(first).starts_with("solid"))
    return read_text(bytes, name);
  if (wanted > 0 && bytes.size() > wanted) return read_binary(bytes, triangles, name);
  throw MeshError(name + ": value " + std::to_string(bytes.size()) +
                  " bytes: expected 'solid', or " + std::to_string(std::max(wanted, kHeaderBytes)) +
                  " bytes of a binary STL");
}

}  // namespace stillgrid::mesh
