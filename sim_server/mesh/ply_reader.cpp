#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include "sim_server/mesh/mesh_formats.hpp"
#include "sim_server/mesh/mesh_text.hpp"

namespace stillgrid::mesh {
namespace {

enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };
enum class Encoding { kText, kLittle, kBig };

struct Property {
  std::string_view name;
  Type type = Type::kFloat;
  std::optional<Type> count_type;  // of a list
};

struct Element {
  std::string_view name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  std::optional<Encoding> encoding;
  std::vector<Element> elements;
};

Type type_named(const MeshText& text, std::string_view word) {
  constexpr std::array<std::array<std::string_view, 2>, 8> kNames = {{{"char", "int8"},
                                                                      {"uchar", "uint8"},
                                                                      {"short", "int16"},
                                                                      {"ushort", "uint16"},
                                                                      {"int", "int32"},
                                                                      {"uint", "uint32"},
                                                                      {"float", "float32"},
                                                                      {"double", "float64"}}};
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (word == kNames[i][0] || word == kNames[i][1]) return static_cast<Type>(i);
  text.refuse("property: value '" + MeshText::shown(word) + "': expected a type, as float");
}

void read_property(MeshText& text, Header& header) {
  constexpr std::size_t kMaxProperties = 256;
  if (header.elements.empty()) text.refuse("property: expected an element before it");
  Property property;
  std::string_view word = text.word();
  if (word == "list") {
    property.count_type = type_named(text, text.word());
    if (*property.count_type >= Type::kFloat)
      text.refuse("property: a list's count: expected a whole type");
    word = text.word();
  }
  property.type = type_named(text, word);
  property.name = text.word();
  header.elements.back().properties.push_back(property);
  if (header.elements.back().properties.size() > kMaxProperties)
    text.refuse("property: expected at most " + std::to_string(kMaxProperties));
}

/// Leaves the text behind the header's last line.
Header read_header(MeshText& text) {
  Header header;
  if (!text.next_line() || text.word() != "ply") text.refuse("expected ply");
  while (text.next_line()) {
    const std::string_view key = text.word();
    if (key == "format") {
      const std::string_view word = text.word();
      header.encoding = word == "ascii"                  ? std::optional(Encoding::kText)
                        : word == "binary_little_endian" ? std::optional(Encoding::kLittle)
                        : word == "binary_big_endian"    ? std::optional(Encoding::kBig)
                                                         : std::nullopt;
    } else if (key == "element") {
      const std::string_view name = text.word();
      header.elements.push_back({name, text.number<std::uint32_t>("element"), {}});
    } else if (key == "property") {
      read_property(text, header);
    } else if (key == "end_header") {
      if (!header.encoding)
        text.refuse("format: expected ascii, binary_little_endian or binary_big_endian");
      return header;
    } else if (key != "comment" && key != "obj_info") {
      text.refuse("value '" + MeshText::shown(key) + "': expected a line of a PLY header");
    }
  }
  text.refuse("ends within its header: expected end_header");
}

/// Numbers one after the other, of text or bytes.
class Values {
 public:
  Values(MeshText& text, Encoding encoding)
      : text_(text), encoding_(encoding), bytes_(text.rest()) {}

  double next(Type type) {
    switch (type) {
      case Type::kInt8:
        return number<std::int8_t>();
      case Type::kUint8:
        return number<std::uint8_t>();
      case Type::kInt16:
        return number<std::int16_t>();
      case Type::kUint16:
        return number<std::uint16_t>();
      case Type::kInt32:
        return number<std::int32_t>();
      case Type::kUint32:
        return number<std::uint32_t>();
      case Type::kFloat:
        return static_cast<double>(number<float>());
      case Type::kDouble:
        break;
    }
    return number<double>();
  }

  [[noreturn]] void refuse(const std::string& what) const {
    text_.refuse((encoding_ == Encoding::kText ? "" : "after the header: ") + what);
  }

 private:
  template <typename Number>
  Number number() {
    if (encoding_ == Encoding::kText) {
      // Whole numbers are written as 3.0 by some.
      const double value = text_.next_number("value");
      if (std::is_integral_v<Number> &&
          !(value >= static_cast<double>(std::numeric_limits<Number>::lowest()) &&
            value <= static_cast<double>(std::numeric_limits<Number>::max())))
        refuse("value: expected one of its type");
      return static_cast<Number>(value);
    }
    if (bytes_.size() < sizeof(Number)) refuse("ends: expected more numbers");
    std::array<char, sizeof(Number)> raw;
    std::copy_n(bytes_.begin(), raw.size(), raw.begin());
    bytes_.remove_prefix(raw.size());
    if ((encoding_ == Encoding::kBig) != (std::endian::native == std::endian::big))
      std::reverse(raw.begin(), raw.end());
    return std::bit_cast<Number>(raw);
  }

  MeshText& text_;
  Encoding encoding_;
  std::string_view bytes_;
};

/// The number of a property of this name, or none.
std::optional<std::size_t> place_of(const Element& element,
                                    std::initializer_list<std::string_view> names, bool is_list) {
  for (std::size_t i = 0; i < element.properties.size(); ++i)
    for (const std::string_view name : names)
      if (element.properties[i].name == name &&
          element.properties[i].count_type.has_value() == is_list)
        return i;
  return std::nullopt;
}

/// Reads one row; visit is given the property's place and each of its values.
template <typename Visit>
void read_row(Values& values, const Element& element, Visit&& visit) {
  realtime::throw_if_stopped();
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const Property& property = element.properties[i];
    const double count = property.count_type ? values.next(*property.count_type) : 1.0;
    if (count < 0.0) values.refuse("a list's count is negative");
    for (double k = 0.0; k < count; ++k) visit(i, values.next(property.type));
  }
}

void read_vertices(Values& values, const Element& element, PolygonMesh& mesh) {
  std::array<std::size_t, 3> places{};
  constexpr std::array<std::string_view, 3> kNames = {"x", "y", "z"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto place = place_of(element, {kNames[axis]}, false);
    if (!place) values.refuse("element vertex: expected properties x, y and z");
    places[axis] = *place;
  }
  for (std::uint64_t row = 0; row < element.count; ++row) {
    Eigen::Vector3d vertex = Eigen::Vector3d::Zero();
    read_row(values, element, [&](std::size_t place, double value) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (places[axis] == place) vertex[static_cast<int>(axis)] = value;
    });
    mesh.add_vertex(vertex.x(), vertex.y(), vertex.z());
  }
}

void read_faces(Values& values, const Element& element, PolygonMesh& mesh) {
  const auto corners = place_of(element, {"vertex_indices", "vertex_index"}, true);
  if (!corners) values.refuse("element face: expected a list vertex_indices");
  for (std::uint64_t row = 0; row < element.count; ++row) {
    read_row(values, element, [&](std::size_t place, double value) {
      if (place == *corners)
        mesh.add_corner(std::abs(value) < 4e9 && value == std::floor(value)
                            ? static_cast<std::int64_t>(value)
                            : PolygonMesh::kNoVertex);
    });
    mesh.end_face();
  }
}

}  // namespace

PolygonMesh read_ply(std::string_view bytes, const std::string& name) {
  MeshText text(bytes, name);
  const Header header = read_header(text);
  Values values(text, *header.encoding);
  PolygonMesh mesh{name, {}, {}, {}};
  for (const Element& element : header.elements) {
    // What takes no bytes could be declared without end.
    if (element.properties.empty()) text.refuse("element: expected properties of each");
    if (element.name == "vertex")
      read_vertices(values, element, mesh);
    else if (element.name == "face")
      read_faces(values, element, mesh);
    else
      for (std::uint64_t row = 0; row < element.count; ++row)
        read_row(values, element, [](std::size_t, double) {});
  }
  return mesh;
}

}  // namespace stillgrid::mesh
