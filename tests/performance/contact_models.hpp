#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "shared/collision/distance_field.hpp"
#include "shared/collision/voxel_grid.hpp"
#include "sim_server/mesh/mesh_distance.hpp"
#include "sim_server/spheres/force_map.hpp"

// All models of contact with a rigid mesh, behind one call each: what a still tool sphere feels.
namespace stillgrid::performance {

/// One model of one mesh. Body's own frame.
struct ContactModel {
  std::string name;
  double size_m = 0.0;       // how fine: spacing, tolerance or cell
  std::size_t parts = 0;     // spheres, bricks or triangles
  double bytes = 0.0;        // that a query reads from
  spheres::UnitForce force;  // N for each N/m, m; as stiff as the material
  std::function<double(const Eigen::Vector3d& tool_m)> touched = {};  // spheres there
};

/// Static spheres as the haptic side finds them: a published voxel grid.
class SphereGrid {
 public:
  explicit SphereGrid(const std::vector<spheres::Ball>& balls);
  [[nodiscard]] Eigen::Vector3d force_m(const Eigen::Vector3d& tool_m, double radius_m) const;
  [[nodiscard]] std::size_t bytes() const { return 8 * view_.layout.total_words; }

 private:
  collision::VoxelGrid grid_;
  collision::GridView view_;
};

/// What models are made of.
struct ModelledMesh {
  std::string name;
  mesh::TriangleMesh mesh;
  double tool_radius_m = 0.0, press_depth_m = 0.0;
  std::shared_ptr<const mesh::MeshDistance> distance;
};

/// Spheres are normalised, as a scene's `normalise` does at the tool's radius and depth.
[[nodiscard]] ContactModel sphere_model(const std::string& name, const ModelledMesh& of,
                                        const std::vector<spheres::Ball>& balls, double size_m);
[[nodiscard]] ContactModel decomposition_model(const ModelledMesh& of, double tolerance_m);
[[nodiscard]] ContactModel even_model(const ModelledMesh& of, double spacing_m);
/// Those of the decomposition to that tolerance.
/// The overlap's volume in the place of its depth, with even spheres.
[[nodiscard]] ContactModel volume_model(const ModelledMesh& of, double spacing_m);
[[nodiscard]] ContactModel field_model(const ModelledMesh& of, double cell_m);
/// Of the exact mesh: its nearest point. Bytes are those of its triangles, without Embree's tree.
[[nodiscard]] ContactModel exact_model(const ModelledMesh& of);

/// Median time of a query at the next of the places, ns: again and again, and with caches flushed
/// before each.
struct QueryTime {
  double hot_ns = 0.0, flushed_ns = 0.0;
};
[[nodiscard]] QueryTime time_query(const ContactModel& model,
                                   const std::vector<Eigen::Vector3d>& places_m, bool is_small);

}  // namespace stillgrid::performance
