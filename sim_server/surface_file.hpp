#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "sim_server/bodies/surfaces.hpp"

namespace stillgrid::sim_server {

/// Writes surfaces for a display (docs/formats.md, "Surfaces"). sphere_count: of the scene, moving
/// and static. Throws std::runtime_error if it cannot be written.
void write_surfaces(const std::string& scene, std::size_t sphere_count,
                    std::span<const bodies::BodySurface> surfaces,
                    const std::filesystem::path& file);

}  // namespace stillgrid::sim_server
