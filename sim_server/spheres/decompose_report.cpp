#include "sim_server/spheres/decompose_report.hpp"

#include <nlohmann/json.hpp>

#include "sim_server/mesh/mass_properties.hpp"
#include "sim_server/spheres/decomposition_error.hpp"

namespace stillgrid::spheres {
namespace {

/// What was read and repaired.
nlohmann::json mesh_fields(const mesh::TriangleMesh& read, const mesh::ClosedMesh& closed) {
  const mesh::MeshRepair& repair = closed.repair;
  return {{"vertices", read.vertices_m.size()},
          {"triangles", read.triangles.size()},
          {"closed",
           {{"vertices", closed.mesh.vertices_m.size()},
            {"triangles", closed.mesh.triangles.size()},
            {"components", closed.components},
            {"folds", closed.folds}}},
          {"repair",
           {{"welded_vertices", repair.welded_vertices},
            {"degenerate_faces", repair.degenerate_faces},
            {"doubled_faces", repair.doubled_faces},
            {"turned_faces", repair.turned_faces},
            {"turned_components", repair.turned_components},
            {"split_vertices", repair.split_vertices},
            {"closed_holes", repair.holes.count}}},
          {"diagonal_m", MeshSolid(closed.mesh).size_m},
          {"volume_m3", mesh::mass_properties(closed.mesh).volume_m3},
          {"area_m2", mesh::surface_area_m2(closed.mesh)}};
}

}  // namespace

nlohmann::json report_fields(const mesh::TriangleMesh& read, const mesh::ClosedMesh& closed,
                             const Fineness& fineness, const Decomposition& made, double time_s) {
  nlohmann::json json = {
      {"mesh", mesh_fields(read, closed)},       {"balls", made.balls.size()},
      {"hausdorff_m", made.hausdorff_m},         {"mesh_to_union_m", made.mesh_to_union_m},
      {"union_to_mesh_m", made.union_to_mesh_m}, {"time_s", time_s}};
  // What was asked for, under the name that a scene has for it.
  if (fineness.tolerance_m > 0.0) json["tolerance_m"] = fineness.tolerance_m;
  if (fineness.surface_spacing_m > 0.0) json["surface_spacing_m"] = fineness.surface_spacing_m;
  if (fineness.volume_spacing_m > 0.0) json["volume_spacing_m"] = fineness.volume_spacing_m;
  return json;
}

}  // namespace stillgrid::spheres
