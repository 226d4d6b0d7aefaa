#pragma once

#include <span>

#include "sim_server/scene/scene_description.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::scene {

/// Reads one [[joint]] of these bodies. Throws SceneError, also where a deformable body has no node
/// near a point, and where neither end could move.
[[nodiscard]] JointDescription read_joint(toml::TableReader& table,
                                          std::span<const bodies::BodyDescription> bodies);

}  // namespace stillgrid::scene
