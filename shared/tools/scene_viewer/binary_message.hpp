#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace stillgrid::scene_viewer {

/// An array of a message, as the page knows it: "f32", "f64" or "u32", little-endian.
struct MessageArray {
  std::string_view name;
  std::string_view type;
  std::size_t count;
  std::span<const std::byte> bytes;
};

/// Pre: values outlives it.
template <class T>
[[nodiscard]] MessageArray array_of(std::string_view name, const std::vector<T>& values) {
  static_assert(std::is_same_v<T, float> || std::is_same_v<T, double> ||
                std::is_same_v<T, std::uint32_t>);
  const std::string_view type = std::is_same_v<T, float>    ? "f32"
                                : std::is_same_v<T, double> ? "f64"
                                                            : "u32";
  return {name, type, values.size(), std::as_bytes(std::span(values))};
}

/// A head and arrays in one: the length of the head, u32 little-endian; the head, JSON with a list
/// "arrays" of {name, type, count}, padded by spaces to a multiple of 4; the arrays back to back.
[[nodiscard]] std::string binary_message(nlohmann::ordered_json head,
                                         std::initializer_list<MessageArray> arrays);

/// With a head that tells the arrays only.
[[nodiscard]] std::string binary_message(std::initializer_list<MessageArray> arrays);

}  // namespace stillgrid::scene_viewer
