#include "sim_server/mesh/mesh_formats.hpp"
#include "sim_server/mesh/mesh_text.hpp"

namespace stillgrid::mesh {
namespace {

/// A corner `vertex[/texture[/normal]]`, from 1, or back from the newest vertex by -1.
std::int64_t corner_of(const MeshText& text, std::string_view word, std::size_t vertices) {
  const auto number = MeshText::number_in<std::int64_t>(word.substr(0, word.find('/')));
  if (!number || *number == 0)
    text.refuse("f: value '" + MeshText::shown(word) + "': expected a vertex's number, from 1");
  return *number > 0 ? *number - 1 : static_cast<std::int64_t>(vertices) + *number;
}

}  // namespace

PolygonMesh read_obj(std::string_view bytes, const std::string& name) {
  MeshText text(bytes, name);
  PolygonMesh mesh{name, {}, {}, {}};
  while (text.next_line()) {
    const std::string_view key = text.word();
    if (key == "v") {
      const double x = text.number("v"), y = text.number("v"), z = text.number("v");
      mesh.add_vertex(x, y, z);
    } else if (key == "f") {
      while (!text.line_is_done()) {
        const std::string_view word = text.word();
        if (word != "\\")
          mesh.add_corner(corner_of(text, word, mesh.vertices.size()));
        else if (!text.next_line())  // the face goes on there
          text.refuse("f: ends with the file: expected the rest of a face");
      }
      mesh.end_face();
    }
  }
  return mesh;
}

}  // namespace stillgrid::mesh
