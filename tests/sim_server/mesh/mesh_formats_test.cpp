#include "sim_server/mesh/mesh_formats.hpp"

#include <catch2/catch.hpp>
#include <string>

#include "sim_server/mesh/mass_properties.hpp"
#include "sim_server/mesh/mesh_file.hpp"
#include "sim_server/mesh/mesh_repair.hpp"

namespace stillgrid::mesh::mesh_formats_test {
namespace {

using Catch::Contains;
using namespace std::string_literals;

const std::string kVertices[] = {"0 0 0", "1 0 0", "0 1 0", "0 0 1"};
const std::string kFaces[] = {"0 2 1", "0 1 3", "1 2 3", "0 3 2"};

double volume(PolygonMesh mesh) {
  return mass_properties(make_closed(cut_into_triangles(std::move(mesh)), "mesh").mesh).volume_m3;
}

TEST_CASE("Comments, blank lines and colours may stand anywhere in an OFF file", "[mesh_formats]") {
  for (const std::string first : {"OFF\n", "", "COFF ", "# by hand\n\nOFF # cube\n#\n\n"})
    for (const std::string edges : {"6", ""}) {
      for (const std::string between : {"\n", "\n\n", " # here\n", "\n# here\n \t\n", "\r\n"}) {
        std::string text = first + "4 4" + between + edges + between;
        for (const std::string& vertex : kVertices) text += vertex + " 1 0.5 0 1" + between;
        for (const std::string& face : kFaces) text += "3 " + face + " 255 0 0" + between;
        INFO(text);
        CHECK(volume(read_off(text, "a.off")) == Approx(1.0 / 6.0));
      }
    }
}

TEST_CASE("A file that ends early, or says more than it holds, is refused with its line",
          "[mesh_formats]") {
  const auto refused = [](auto reader, const std::string& bytes, const std::string& line) {
    INFO(bytes);
    CHECK_THROWS_WITH(cut_into_triangles(reader(bytes, "m")), Contains(line));
  };
  refused(read_off, "OFF\n4000000000 1 0\n0 0 0\n", "m:3: ends after 1 vertices: expected 4000");
  refused(read_off, "OFF\n1 1 0\n0 0 0\n4000000000 0 0\n", "m:4: corner: the file ends");
  refused(read_off, "OFF\n1 1\n0 zero 0\n", "m:3: vertex: value 'zero': expected a number");
  refused(read_off, "4OFF\n", "m:1: value '4OFF'");
  refused(read_off, "", "is empty");
  refused(read_obj, "v 0 0\n", "m:1: v: value '': expected a number");
  refused(read_obj, "v 0 0 0\nf 1 0 1\n", "m:2: f: value '0'");
  refused(read_obj, "v 0 0 0\nf 1 -2 1\n", "face 1 of 3 corners: names a vertex that is none");
  refused(read_obj, "v 0 0 0\nf 1 1 \\\n", "m:2: f: ends with the file");
  refused(read_stl, "solid\nvertex 0 0 0\n", "m:2: vertex: outside of a loop");
  refused(read_stl, "solid\nouter loop\nvertex 0 0 0\n", "m:3: ends within a loop");
  refused(read_stl, std::string(83, 'x'), "value 83 bytes");
  std::string endless(80, 'x');
  endless.append(4, '\xff');
  refused(read_stl, endless, "value 84 bytes");
  const std::string head = "ply\nformat ascii 1.0\nelement vertex 2\n";
  refused(read_ply, head.substr(0, 20), "ends within its header");
  refused(read_ply, head + "end_header\n", "element: expected properties");
  refused(read_ply, head + "property float x\nend_header\n0 0\n", "expected properties x, y and z");
  refused(read_ply, head + "property number x\n", "m:4: property: value 'number'");
  refused(read_ply,
          "ply\nformat binary_big_endian 1.0\nelement face 4000000000\n"
          "property list char int vertex_index\nend_header\n\0\0\xff"s,
          "a list's count is negative");
  refused(read_ply, "ply\nformat binary 1.0\nend_header\n", "format: expected ascii");
}

TEST_CASE("A value in a message is short and harmless", "[mesh_formats]") {
  CHECK_THROWS_WITH(read_obj("v \x1b[2J" + std::string(1000, 'x'), "m"),
                    Contains("value '?[2Jxxx") && !Contains(std::string(41, 'x')));
}

TEST_CASE("Text and both orders of bytes of a PLY file are one mesh", "[mesh_formats]") {
  const std::string rest =
      " 1.0\ncomment # by hand\nelement extra 1\nproperty list uchar short things\n"
      "element vertex 4\nproperty uchar x\nproperty uchar red\nproperty uchar y\n"
      "property uchar z\nelement face 4\nproperty list uchar uchar vertex_indices\nend_header\n";
  std::string text = "ply\nformat ascii" + rest + "2 500 600\n", bytes = "\x02";
  for (const std::string& vertex : kVertices) {
    text += vertex.substr(0, 1) + " 9" + vertex.substr(1) + "\n";
    for (const int at : {0, -1, 2, 4})
      bytes += at < 0 ? '\x09' : static_cast<char>(vertex[static_cast<std::size_t>(at)] - '0');
  }
  for (const std::string& face : kFaces) {
    text += "3 " + face + "\n";
    bytes += '\x03';
    for (const std::size_t at : {0U, 2U, 4U}) bytes += static_cast<char>(face[at] - '0');
  }
  CHECK(volume(read_ply(text, "m")) == Approx(1.0 / 6.0));
  for (const std::string order : {"little", "big"}) {
    std::string file = "ply\nformat binary_" + order + "_endian" + rest + bytes;
    file.insert(file.find("end_header\n") + 11 + 1, 4, '\x05');  // the two shorts of a list
    CHECK(volume(read_ply(file, "m")) == Approx(1.0 / 6.0));
  }
}

TEST_CASE("A mesh has at most two million triangles", "[mesh_formats]") {
  PolygonMesh mesh{"large", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}, {}};
  for (std::size_t i = 0; i < kMaxTriangles; ++i) mesh.end_face();
  CHECK_THROWS_WITH(mesh.end_face(), Contains("large: more than 2000000 faces"));
}

}  // namespace
}  // namespace stillgrid::mesh::mesh_formats_test
