#pragma once

#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "sim_server/spheres/ball.hpp"

namespace stillgrid::spheres {

/// Reads a CSV of sphere_decompose: the header `x_m,y_m,z_m,radius_m`, then a row a sphere; lines
/// that begin with # are skipped.
///
/// Throws std::runtime_error naming file, line and value for anything but finite numbers and
/// positive radii, and for a file without a sphere.
[[nodiscard]] std::vector<Ball> read_spheres(const std::filesystem::path& file);

/// Writes that CSV, every number so that it reads back the same. The file is replaced whole or not
/// at all. Throws std::runtime_error if it cannot be written.
/// A comment, one line, goes before the header.
void write_spheres(std::span<const Ball> balls, const std::filesystem::path& file,
                   std::string_view comment = {});

}  // namespace stillgrid::spheres
