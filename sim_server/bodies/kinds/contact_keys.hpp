#pragma once

#include <optional>

#include "sim_server/bodies/kinds/mesh.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::bodies {

/// Reads how a mesh is to be met: `contact`, `field`, `force_error`. Nothing: through its spheres.
/// Throws SceneError, at keys that do not apply too.
[[nodiscard]] std::optional<AskedField> read_contact(toml::TableReader& table,
                                                     const mesh::TriangleMesh& mesh, bool is_soft,
                                                     Motion motion);

/// A share of a force: a number from more than 0 to 1000, as such or as text, with `%` behind it,
/// or with `jnd` in just noticeable differences, as scene_fit takes it. Throws SceneError.
[[nodiscard]] double read_force_error(toml::TableReader& table, std::string_view key);

}  // namespace stillgrid::bodies
