#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace stillgrid::toml {

/// Whether one word is likely what somebody meant who wrote the other: they differ by a slip of the
/// pen (a letter of four added, lost, changed, or two swapped), by capitals, by a plural, by units
/// that end a key (`mass` and `mass_kg`, `radius_mm` and `radius_m`), or by words that begin it and
/// were left out (`stiffness` and `spring_stiffness_N_per_m`). A word is not near to itself.
[[nodiscard]] bool is_near(std::string_view written, std::string_view word);

/// The word that is near to what was written by the fewest letters, the first of several; none if
/// none is near.
[[nodiscard]] std::optional<std::string_view> near_word(std::string_view written,
                                                        std::span<const std::string_view> words);

}  // namespace stillgrid::toml
