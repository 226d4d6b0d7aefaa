#include "sim_server/toml/refusal.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <sstream>

namespace stillgrid::toml {
namespace {

constexpr std::size_t kLongestValue = 60;  // bytes shown of a value

std::string one_line(std::string text) {
  std::replace_if(text.begin(), text.end(), is_control, ' ');
  return text;
}

std::string written(const ::toml::node& node) {
  if (node.is_table()) return "{...}";
  if (const auto* number = node.as_floating_point()) {
    // The library prints 17 digits: 0.1 would not be shown as the file has it.
    std::array<char, 32> digits{};
    char* const end =
        std::to_chars(digits.data(), digits.data() + digits.size(), number->get()).ptr;
    return {digits.data(), end};
  }
  if (const ::toml::array* array = node.as_array()) {
    std::string list;
    for (const ::toml::node& item : *array) list += (list.empty() ? "" : ", ") + written(item);
    return "[" + list + "]";
  }
  std::ostringstream text;
  node.visit([&text](const auto& value) { text << value; });
  return text.str();
}

std::string refusal_line(std::string_view file, const ::toml::source_position& where,
                         std::string_view key, std::string_view value, std::string_view why) {
  std::ostringstream message;
  message << file << ':' << std::max(where.line, 1U) << ':' << std::max(where.column, 1U) << ": "
          << key << ": value " << value << ": " << why;
  return one_line(message.str());
}

}  // namespace

bool is_control(char c) noexcept {
  return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
}

std::string shortened(std::string text) {
  if (text.size() <= kLongestValue) return text;
  std::size_t end = kLongestValue;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0U) == 0x80U) --end;
  text.resize(end);
  return text + "...";
}

std::string shown(const ::toml::node& node) {
  return shortened(one_line(written(node)));
}

std::string_view type_of(const ::toml::node& node) noexcept {
  switch (node.type()) {
    case ::toml::node_type::string:
      return "a string";
    case ::toml::node_type::integer:
      return "an integer";
    case ::toml::node_type::floating_point:
      return "a number";
    case ::toml::node_type::boolean:
      return "a boolean";
    case ::toml::node_type::array:
      return "an array";
    case ::toml::node_type::table:
      return "a table";
    default:
      return "a date or time";
  }
}

SceneError scene_error(std::string_view file, const ::toml::source_position& where,
                       std::string_view key, std::string_view value, std::string_view expected) {
  return SceneError{refusal_line(file, where, key, value, "expected " + std::string(expected))};
}

SceneError unknown_key(std::string_view file, const ::toml::source_position& where,
                       const std::string& prefix, std::string_view key, const ::toml::node& value,
                       std::string_view meant, const std::string& owner) {
  const bool is_table = prefix.empty() && (value.is_table() || value.is_array_of_tables());
  std::string why = is_table ? "unknown table `" : "unknown key `";
  why.append(key).append("`: did you mean `").append(meant).append("`?").append(owner);
  return SceneError{refusal_line(file, where, prefix + std::string(key), shown(value), why)};
}

}  // namespace stillgrid::toml
