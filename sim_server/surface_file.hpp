#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "sim_server/bodies/surfaces.hpp"

namespace stillgrid::sim_server {

/// Writes names and surfaces of bodies for a display (docs/formats.md, "Surfaces"). names: of all
/// bodies, in the order of the scene file. sphere_count: of the scene, moving and static. Throws
/// std::runtime_error if it cannot be written.
void write_surfaces(const std::string& scene, const std::vector<std::string>& names,
                    std::size_t sphere_count, std::span<const bodies::BodySurface> surfaces,
                    const std::filesystem::path& file);

}  // namespace stillgrid::sim_server
