#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "shared/collision/distance_field.hpp"
#include "sim_server/bodies/kinds/packing.hpp"
#include "sim_server/bodies/kinds/springs.hpp"
#include "sim_server/bodies/surfaces.hpp"
#include "sim_server/fields/measured_surface.hpp"
#include "sim_server/mesh/triangle_mesh.hpp"
#include "sim_server/spheres/ball.hpp"

namespace stillgrid::toml {
class TableReader;
}

namespace stillgrid::bodies {

struct BodyDescription;

/// The field of a rigid mesh, as its scene describes it.
struct AskedField {
  std::optional<double> cell_m = {};      // none: fields::default_cell_m()
  std::optional<double> band_m = {};      // none: the radius of the scene's largest tool sphere
  unsigned line = 0;                      // of the scene file, where it is asked for
  std::filesystem::path folder = {};      // of the scene file
  fields::MeasuredSurface measured = {};  // own_N_per_m is set by make_fields()
};

/// A mesh from a file that keeps its shape, in its centre of mass along its principal axes,
/// whatever frame the file has: met through its balls, or through its field. A thin shell if it
/// bounds no solid.
struct RigidMeshBody {
  /// Balls of a body that is met through its balls. A body with a field has points of its surface
  /// here if it may move.
  std::vector<spheres::Ball> balls = {};
  mesh::TriangleMesh surface = {};  // closed, but for a shell; for a display
  std::string no_solid = {};        // why it is a shell, which cover_shells() covers with balls
  Eigen::Vector3d inertia_per_kg_m2 = Eigen::Vector3d::Zero();  // principal
  std::optional<AskedField> asked_field = {};
  std::shared_ptr<const collision::DistanceField> field = {};  // make_fields() makes it
};

/// A mesh from a file as balls on a lattice of masses and springs, in the file's frame.
struct SoftMeshBody {
  std::vector<spheres::Ball> balls = {};
  mesh::TriangleMesh surface = {};  // closed; for a display
  SoftLattice lattice = {};         // lattice_round()
  ShearSprings springs = {};
};

/// Reads its keys into body.shape: a soft mesh if it has springs. Adds a line to notes. Throws
/// SceneError. A mesh that bounds no solid is a shell. It is refused at `file` if it is soft or has
/// a key of its contact. Decomposing may take seconds. A field is only asked for: make_fields()
/// makes it. Pre: body.motion is read.
void read_mesh(toml::TableReader& table, BodyDescription& body, std::vector<std::string>& notes);

[[nodiscard]] BodyCounts counts_of(const RigidMeshBody& mesh);
[[nodiscard]] BodyCounts counts_of(const SoftMeshBody& mesh);

/// Masses and springs of one that stands where body says.
[[nodiscard]] SpringNet net_of(const SoftMeshBody& mesh, const BodyDescription& body);
/// Returns the mesh as a rigid body of that mass.
[[nodiscard]] RigidShape rigid_shape(const RigidMeshBody& mesh, double mass_kg);
[[nodiscard]] std::vector<SphereBinding> spheres_of(const RigidMeshBody& mesh,
                                                    const BodyDescription& body);
[[nodiscard]] std::vector<SphereBinding> spheres_of(const SoftMeshBody& mesh,
                                                    const BodyDescription& body);

[[nodiscard]] BodySurface surface_of(const RigidMeshBody& mesh, const BodyDescription& body,
                                     const RestSpheres& spheres);
[[nodiscard]] BodySurface surface_of(const SoftMeshBody& mesh, const BodyDescription& body,
                                     const RestSpheres& spheres);

}  // namespace stillgrid::bodies
