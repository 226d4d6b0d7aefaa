#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace stillgrid::scene_viewer {

// What a saved view holds is checked with these before it is shown; Json: either of nlohmann's.

/// Text of a stranger as JSON, discarded where it is none. What nests deeper than a viewer writes
/// is left out: to copy or to print it would take stack without end.
template <class Json>
[[nodiscard]] Json parse_shallow(std::string_view text) {
  constexpr int kMaxDepth = 16;
  return Json::parse(
      text, [](int depth, auto, const Json&) { return depth <= kMaxDepth; }, false);
}

/// A member, or null where there is none.
template <class Json>
[[nodiscard]] const Json& at(const Json& json, const char* name) {
  static const Json kNone;
  if (!json.is_object()) return kNone;
  const auto found = json.find(name);
  return found == json.end() ? kNone : *found;
}

template <class Json>
[[nodiscard]] bool is_number_or_null(const Json& json) {
  return json.is_number() || json.is_null();
}

/// A list of so many numbers, each null where it was none: a scene's writer may publish anything.
template <class Json>
[[nodiscard]] bool are_numbers_or_null(const Json& json, std::size_t count) {
  return json.is_array() && json.size() == count &&
         std::all_of(json.begin(), json.end(),
                     [](const Json& value) { return is_number_or_null(value); });
}

/// The levels of a grid, as far as the page reads them.
template <class Json>
[[nodiscard]] bool are_levels(const Json& levels) {
  return levels.is_array() && std::all_of(levels.begin(), levels.end(), [](const Json& level) {
           return level.is_object() && level.contains("voxel_m") &&
                  is_number_or_null(level["voxel_m"]);
         });
}

}  // namespace stillgrid::scene_viewer
