#pragma once

#include <toml++/toml.h>

#include <string>
#include <string_view>
#include <vector>

#include "sim_server/toml/scene_error.hpp"

namespace stillgrid::scene {

/// A key of format 1 that was read by its name of format 2, and where it stands first.
struct RenewedKey {
  std::string_view before, now;
  ::toml::source_position where;
};

/// Gives the keys of a scene of format 1 the names of format 2 (shared/files/old_names.hpp), with
/// their values and places in the file; returns each old name once, in the file's order. Throws
/// SceneError for a table that has both names of a key.
[[nodiscard]] std::vector<RenewedKey> renew_format_1(::toml::table& document,
                                                     const std::string& file);

/// Throws SceneError at a key of format 1, naming that of format 2: for scenes of format 2.
void refuse_format_1(const ::toml::table& document, const std::string& file);

/// What the user is told of keys that were renewed: a line each.
[[nodiscard]] std::vector<std::string> lines_of(const std::vector<RenewedKey>& renewed,
                                                const std::string& file);

/// The same of a scene that was refused, which is one line: its refusal, and what each key that it
/// may name is called in the file.
[[nodiscard]] toml::SceneError with_names_of_file(const toml::SceneError& refusal,
                                                  const std::vector<RenewedKey>& renewed);

}  // namespace stillgrid::scene
