#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>

namespace stillgrid::files::json_number {

/// What is no number is null.
[[nodiscard]] inline nlohmann::ordered_json number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

/// The shortest decimal that reads back as this float: 0.005, not 0.004999999888241291.
[[nodiscard]] inline nlohmann::ordered_json number(float value) {
  if (!std::isfinite(value)) return {};
  std::array<char, 32> text{};
  double shortest = 0.0;
  auto* const end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  std::from_chars(text.data(), end, shortest);
  return shortest;
}

template <class T, std::size_t N>
[[nodiscard]] nlohmann::ordered_json numbers(const std::array<T, N>& values) {
  auto json = nlohmann::ordered_json::array();
  for (const T value : values) json.push_back(number(value));
  return json;
}

}  // namespace stillgrid::files::json_number
