#pragma once

#include <toml++/toml.h>

#include <string>
#include <string_view>

#include "sim_server/toml/scene_error.hpp"

namespace stillgrid::toml {

/// A refusal as one line, whatever its parts hold.
[[nodiscard]] SceneError scene_error(std::string_view file, const ::toml::source_position& where,
                                     std::string_view key, std::string_view value,
                                     std::string_view expected);

/// The refusal of a key of a table that is likely another one, as one line, which ends with owner.
[[nodiscard]] SceneError unknown_key(std::string_view file, const ::toml::source_position& where,
                                     const std::string& prefix, std::string_view key,
                                     const ::toml::node& value, std::string_view meant,
                                     const std::string& owner);

/// The text as it is shown for a value: cut when it is long, never within a character.
[[nodiscard]] std::string shortened(std::string text);

/// A value much as the file has it, on one line.
[[nodiscard]] std::string shown(const ::toml::node& node);

/// The type of a value in words: "a string".
[[nodiscard]] std::string_view type_of(const ::toml::node& node) noexcept;

/// Whether a character would break or disturb a line.
[[nodiscard]] bool is_control(char c) noexcept;

}  // namespace stillgrid::toml
