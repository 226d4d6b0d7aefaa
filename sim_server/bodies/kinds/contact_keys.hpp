#pragma once

#include <optional>

#include "sim_server/bodies/kinds/mesh.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::bodies {

/// Reads `contact` and `field` of a mesh body. Returns nothing for contact by spheres, the default
/// of a soft mesh and of a body with the key `spheres`. Throws SceneError, at keys that do not
/// apply too.
[[nodiscard]] std::optional<AskedField> read_contact(toml::TableReader& table,
                                                     const mesh::TriangleMesh& mesh, bool is_soft,
                                                     Motion motion);

}  // namespace stillgrid::bodies
