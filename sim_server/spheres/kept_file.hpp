#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "sim_server/mesh/triangle_mesh.hpp"

namespace stillgrid::spheres {

/// FNV-1a, 64 bits: finds accidents, not forgers; who may write a cache may write the scene too.
class Hash {
 public:
  void add(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) value_ = (value_ ^ bytes[i]) * 0x100000001b3ULL;
  }
  void add(double value) { add(&value, sizeof value); }
  void add(const Eigen::Vector3d& point) { add(point.data(), 3 * sizeof(double)); }
  void add(const mesh::TriangleMesh& mesh);
  [[nodiscard]] std::uint64_t value() const noexcept { return value_; }
  /// Sixteen hexadecimal digits.
  [[nodiscard]] std::string text() const;

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

/// The folder `.stillgrid` beside a scene, for what took long to make.
[[nodiscard]] std::filesystem::path kept_folder(const std::filesystem::path& scene_folder);

/// Whether a file that was kept may be read: a regular one, in a folder that nobody else can have
/// put anything into. Links and pipes are not followed.
[[nodiscard]] bool may_read_kept(const std::filesystem::path& file);

/// Makes the file's folder where there is none. Throws std::runtime_error naming the file where it
/// cannot be made, or where others may write into it.
void prepare_kept(const std::filesystem::path& file);

}  // namespace stillgrid::spheres
