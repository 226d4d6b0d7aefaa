#include "sim_server/spheres/sphere_cache.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>

#include "sim_server/spheres/kept_file.hpp"
#include "sim_server/spheres/sphere_file.hpp"

namespace stillgrid::spheres {
namespace {

std::string name_of(const mesh::TriangleMesh& closed, std::string_view way, double value_m) {
  Hash hash;
  hash.add(&kDecomposerVersion, sizeof kDecomposerVersion);
  hash.add(way.data(), way.size());
  hash.add(value_m);
  hash.add(closed);
  return hash.text() + ".csv";
}

}  // namespace

SphereCache::SphereCache(const std::filesystem::path& scene_folder,
                         const mesh::TriangleMesh& closed, std::string_view way, double value_m)
    : file_(kept_folder(scene_folder) / name_of(closed, way, value_m)), value_m_(value_m) {}

/// All but the spheres, and a checksum of both.
std::string SphereCache::first_line(const Decomposition& made) const {
  Hash hash;
  for (const Ball& ball : made.balls) {
    hash.add(ball.centre_m);
    hash.add(ball.radius_m);
  }
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(),
                "%zu spheres, mesh_to_union_m = %.17g, union_to_mesh_m = %.17g, of %.17g m",
                made.balls.size(), made.mesh_to_union_m, made.union_to_mesh_m, value_m_);
  hash.add(text.data(), std::string_view(text.data()).size());
  return std::string(text.data()) + ", checksum " + hash.text();
}

std::optional<Decomposition> SphereCache::read() const {
  if (!may_read_kept(file_)) return std::nullopt;
  std::ifstream in(file_);
  std::string line;
  Decomposition kept;
  std::size_t count = 0;
  if (!in || !std::getline(in, line) ||
      std::sscanf(line.c_str(), "# %zu spheres, mesh_to_union_m = %lg, union_to_mesh_m = %lg",
                  &count, &kept.mesh_to_union_m, &kept.union_to_mesh_m) != 3)
    return std::nullopt;
  try {
    kept.balls = read_spheres(file_);
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
  if (line != "# " + first_line(kept)) return std::nullopt;
  kept.hausdorff_m = std::max(kept.mesh_to_union_m, kept.union_to_mesh_m);
  kept.tolerance_m = value_m_;
  return kept;
}

void SphereCache::write(const Decomposition& made) const {
  prepare_kept(file_);
  write_spheres(made.balls, file_, first_line(made));
}

}  // namespace stillgrid::spheres
