#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include "sim_server/spheres/decomposition.hpp"

namespace stillgrid::spheres {

/// Spheres that were made of a mesh before, in a file of a folder `.stillgrid` beside a scene.
///
/// The file's name is a hash of the closed mesh, of what was asked of it, and of the version of the
/// decomposer, so that it is found only by what would be made again; a checksum within says that it
/// is whole. What is read is what was written, to the bit. Docs: docs/formats.md.
class SphereCache {
 public:
  /// `way` is the scene's key, as tolerance_m, with its value. Touches no file.
  SphereCache(const std::filesystem::path& scene_folder, const mesh::TriangleMesh& closed,
              std::string_view way, double value_m);

  /// What was kept, or nothing: also where the file is damaged, or cannot be read.
  [[nodiscard]] std::optional<Decomposition> read() const;

  /// Keeps spheres, whole or not at all. Throws std::runtime_error naming the file where it cannot
  /// be written, as in a folder that may only be read.
  void write(const Decomposition& made) const;

  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

 private:
  [[nodiscard]] std::string first_line(const Decomposition& made) const;

  std::filesystem::path file_;
  double value_m_;
};

}  // namespace stillgrid::spheres
