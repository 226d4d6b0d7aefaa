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

}  // namespace stillgrid::bodies
