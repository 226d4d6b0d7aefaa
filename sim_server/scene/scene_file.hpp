#pragma once

#include <filesystem>
#include <string>

#include "sim_server/scene/scene_description.hpp"
#include "sim_server/toml/scene_error.hpp"

namespace stillgrid::scene {

/// Reads and checks a scene; docs/formats.md describes the file.
///
/// Throws SceneError, and says where, for a file that cannot be read, for what is not TOML,
/// for a key that is unknown where it stands, and for a value of the wrong type or beyond
/// what it may be. Every number of the result is finite, also as a float. integrators: those
/// that it may name.
[[nodiscard]] SceneDescription load_scene(const std::filesystem::path& path,
                                          Integrators integrators = kIntegrators);

/// The same of a text that would stand in that file; throws alike. The scene is named after the
/// file, and files that it names are looked for from its folder.
[[nodiscard]] SceneDescription read_scene(const std::string& text,
                                          const std::filesystem::path& path,
                                          Integrators integrators = kIntegrators);

/// Throws std::runtime_error, one line, where a scene names its hands: who calls it knows one.
void require_one_hand(const SceneDescription& scene, const std::filesystem::path& path);

}  // namespace stillgrid::scene
