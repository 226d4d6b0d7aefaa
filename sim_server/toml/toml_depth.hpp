#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace stillgrid::toml {

/// Where a text nests deeper than a parser should follow, and what is expected there.
struct DeepPlace {
  unsigned line = 1, column = 1;  // from one
  std::string expected;           // "a key of at most 16 parts"
};

/// The first place of a TOML text with a key of more than 16 parts, or with brackets within more
/// than 16 others. A parser that recurses ends its process there, so it is looked for before one is
/// asked. One pass; of what is no TOML it may say either.
[[nodiscard]] std::optional<DeepPlace> find_deep_place(std::string_view text);

}  // namespace stillgrid::toml
