#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::fit_run {

/// The file that a user means: a path, or the name of a scene that ships, as of replay_check.
/// Throws std::runtime_error for neither.
[[nodiscard]] std::filesystem::path find_scene(const std::string& name);

/// A scene file's text with other values: each setting is KEY=VALUE, VALUE as TOML has it.
///
/// KEY is `table.key` (`simulation.rate_hz`), or `body.NAME.key`, `material.NAME.key`
/// (`body.tissue.spheres.spacing_m`). What a setting contradicts goes, unless it is set too:
/// rate_hz replaces period_s and the reverse; an integrator the file's whole
/// method; of `spheres`, one way to make a mesh's the others.
///
/// Throws std::runtime_error, one line with the setting, for one that is none of these. Whether the
/// key is known is for read_scene() to say.
[[nodiscard]] std::string with_settings(const std::string& text,
                                        const std::vector<std::string>& settings);

/// The scene of that file with those settings, all checks made; a setting may name a method of the
/// laboratory, to be compared. Throws SceneError, or
/// std::runtime_error for what is wrong by the settings only: one line that shows them.
[[nodiscard]] scene::SceneDescription load_scene_with(const std::filesystem::path& file,
                                                      const std::vector<std::string>& settings);

}  // namespace stillgrid::fit_run
