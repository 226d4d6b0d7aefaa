#include "sim_server/spheres/kept_file.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <stdexcept>
#include <system_error>

namespace stillgrid::spheres {
namespace {

bool is_own(const std::filesystem::path& folder) {
  struct stat status {};
  return ::lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) &&
         status.st_uid == ::geteuid() && (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

}  // namespace

void Hash::add(const mesh::TriangleMesh& mesh) {
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) add(vertex);
  for (const Eigen::Vector3i& triangle : mesh.triangles) add(triangle.data(), 3 * sizeof(int));
}

std::string Hash::text() const {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value_));
  return text.data();
}

std::filesystem::path kept_folder(const std::filesystem::path& scene_folder) {
  return scene_folder / ".stillgrid";
}

bool may_read_kept(const std::filesystem::path& file) {
  return is_own(file.parent_path()) &&
         std::filesystem::is_regular_file(std::filesystem::symlink_status(file));
}

void prepare_kept(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::create_directory(file.parent_path(), error))
    std::filesystem::permissions(file.parent_path(), std::filesystem::perms(0755), error);
  if (error) throw std::runtime_error(file.string() + ": cannot be written: " + error.message());
  if (!is_own(file.parent_path()))
    throw std::runtime_error(file.parent_path().string() +
                             ": expected a folder of this user's that only this user may write");
}

}  // namespace stillgrid::spheres
