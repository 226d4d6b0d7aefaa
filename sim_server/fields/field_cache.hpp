#pragma once

#include <filesystem>
#include <optional>

#include "shared/collision/distance_field.hpp"
#include "sim_server/fields/measured_surface.hpp"
#include "sim_server/mesh/triangle_mesh.hpp"

namespace stillgrid::fields {

/// A field that was made of a mesh before, in a file of the folder `.stillgrid` beside a scene, as
/// spheres::SphereCache keeps spheres: found only by what would be made again, and to the bit.
class FieldCache {
 public:
  /// Touches no file.
  FieldCache(const std::filesystem::path& scene_folder, const mesh::TriangleMesh& closed,
             const collision::FieldFineness& fineness, const MeasuredSurface& measured = {});

  /// What was kept, or nothing: also where the file is damaged, or cannot be read.
  [[nodiscard]] std::optional<collision::DistanceField> read() const;

  /// Keeps a field, whole or not at all. Throws std::runtime_error naming the file where it cannot
  /// be written, as in a folder that may only be read.
  void write(const collision::DistanceField& field) const;

  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

 private:
  std::filesystem::path file_;
};

}  // namespace stillgrid::fields
