#include "sim_server/mesh/mesh_formats.hpp"
#include "sim_server/mesh/mesh_text.hpp"

namespace stillgrid::mesh {
namespace {

/// Past the first word, if there is one; the counts may be on its line.
void read_first_word(MeshText& text) {
  if (!text.next_line()) text.refuse("is empty: expected OFF");
  MeshText ahead = text;
  const std::string_view word = ahead.word();
  if (MeshText::number_in<double>(word)) return;
  if (!word.ends_with("OFF") || word.find_first_not_of("STCN") != word.size() - 3)
    text.refuse("value '" + MeshText::shown(word) +
                "': expected OFF, with colours COFF, with normals NOFF, in three dimensions");
  text = ahead;
  if (text.line_is_done() && !text.next_line()) text.refuse("ends: expected three counts");
  MeshText counts = text;
  if (counts.word() == "BINARY") text.refuse("is binary: expected OFF as text");
}

/// The third count tells nothing; some leave it out, some give it a line of its own.
void skip_edge_count(MeshText& text) {
  MeshText ahead = text;
  if (!text.line_is_done() || !ahead.next_line()) return;
  ahead.word();
  if (ahead.line_is_done()) text = ahead;
}

}  // namespace

PolygonMesh read_off(std::string_view bytes, const std::string& name) {
  MeshText text(bytes, name);
  PolygonMesh mesh{name, {}, {}, {}};
  read_first_word(text);
  const auto vertices = text.next_number<std::uint32_t>("vertices");
  const auto faces = text.next_number<std::uint32_t>("faces");
  skip_edge_count(text);
  const auto next = [&](const char* what, std::uint32_t i, std::uint32_t count) {
    if (!text.next_line())
      text.refuse("ends after " + std::to_string(i) + " " + what + ": expected " +
                  std::to_string(count));
  };
  for (std::uint32_t i = 0; i < vertices; ++i) {
    next("vertices", i, vertices);
    const double x = text.next_number("vertex"), y = text.next_number("vertex"),
                 z = text.next_number("vertex");
    mesh.add_vertex(x, y, z);
  }
  for (std::uint32_t i = 0; i < faces; ++i) {
    next("faces", i, faces);
    const auto corners = text.number<std::uint32_t>("corners of a face");
    for (std::uint32_t k = 0; k < corners; ++k)
      mesh.add_corner(text.next_number<std::int64_t>("corner"));
    mesh.end_face();
  }
  return mesh;
}

}  // namespace stillgrid::mesh
