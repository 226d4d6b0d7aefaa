#include "sim_server/spheres/sphere_cache.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>

#include "sim_server/spheres/sphere_file.hpp"

namespace stillgrid::spheres {
namespace {

/// FNV-1a, 64 bits: finds accidents, not forgers; who may write here may write the scene too.
class Hash {
 public:
  void add(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) value_ = (value_ ^ bytes[i]) * 0x100000001b3ULL;
  }
  void add(double value) { add(&value, sizeof value); }
  void add(const Eigen::Vector3d& point) { add(point.data(), 3 * sizeof(double)); }
  [[nodiscard]] std::string text() const {
    std::array<char, 17> text{};
    std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value_));
    return text.data();
  }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

/// A folder that nobody else can have put anything into: links and pipes of others are not
/// followed.
bool is_own(const std::filesystem::path& folder) {
  struct stat status {};
  return ::lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) &&
         status.st_uid == ::geteuid() && (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

std::string name_of(const mesh::TriangleMesh& closed, std::string_view way, double value_m) {
  Hash hash;
  hash.add(&kDecomposerVersion, sizeof kDecomposerVersion);
  hash.add(way.data(), way.size());
  hash.add(value_m);
  for (const Eigen::Vector3d& vertex : closed.vertices_m) hash.add(vertex);
  for (const Eigen::Vector3i& triangle : closed.triangles)
    hash.add(triangle.data(), 3 * sizeof(int));
  return hash.text() + ".csv";
}

}  // namespace

SphereCache::SphereCache(const std::filesystem::path& scene_folder,
                         const mesh::TriangleMesh& closed, std::string_view way, double value_m)
    : file_(scene_folder / ".stillgrid" / name_of(closed, way, value_m)), value_m_(value_m) {}

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
  if (!is_own(file_.parent_path()) ||
      !std::filesystem::is_regular_file(std::filesystem::symlink_status(file_)))
    return std::nullopt;
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
  std::error_code error;
  if (std::filesystem::create_directory(file_.parent_path(), error))
    std::filesystem::permissions(file_.parent_path(), std::filesystem::perms(0755), error);
  if (error) throw std::runtime_error(file_.string() + ": cannot be written: " + error.message());
  if (!is_own(file_.parent_path()))
    throw std::runtime_error(file_.parent_path().string() +
                             ": expected a folder of this user's that only this user may write");
  write_spheres(made.balls, file_, first_line(made));
}

}  // namespace stillgrid::spheres
