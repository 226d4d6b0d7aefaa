#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim_server/scene/scene_description.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::scene {

/// Reads one [[body]], its defaults filled in. Throws SceneError.
///
/// A key that its kind does not have is unknown. A mass, a velocity, an amplitude of a motion that
/// has none is refused. Springs and pinned nodes may stay on a body that is static: of a mesh they
/// say that it is soft. A mesh of spheres adds a line to
/// notes.
[[nodiscard]] bodies::BodyDescription read_body(toml::TableReader& table,
                                                std::span<const MaterialDescription> materials,
                                                std::vector<std::string>& notes);

}  // namespace stillgrid::scene
