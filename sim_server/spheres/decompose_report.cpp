#include "sim_server/spheres/decompose_report.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "sim_server/mesh/mass_properties.hpp"
#include "sim_server/spheres/decomposition_error.hpp"

namespace stillgrid::spheres {
namespace {

nlohmann::json or_null(double value) {
  return value > 0.0 ? nlohmann::json(value) : nlohmann::json();
}

/// Forces for a contact stiffness of 1 N/m.
nlohmann::json force_fields(const Press& press, const Feel& feel) {
  const ForceMap& map = feel.map;
  return {{"tool_radius_m", press.tool_radius_m},
          {"press_depth_m", press.depth_m},
          {"places", press.surface.points_m.size()},
          {"mean_m", map.mean_m},
          {"ripple", map.ripple},
          {"least_over_most", map.min_over_max},
          {"peak_to_peak", map.peak_to_peak},
          {"hole_share", map.hole_share},
          {"reversed_share", map.reversed_share},
          {"tangential", map.tangential},
          {"effective_stiffness", map.effective_stiffness},
          {"stiffness_scale",
           or_null(map.effective_stiffness > 0.0 ? 1.0 / map.effective_stiffness : 0.0)},
          {"error_share", feel.error.share},
          {"error_jnd", feel.error.jnd()},
          {"error_stiffness_scale", or_null(feel.error.stiffness_scale)},
          {"fault", is_worse_than_nearest_face(feel)
                        ? nlohmann::json(fault_of(feel) + ", worse than the nearest face")
                        : nlohmann::json()}};
}

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
            {"split_vertices", repair.split_vertices}}},
          {"diagonal_m", MeshSolid(closed.mesh).size_m},
          {"volume_m3", mesh::mass_properties(closed.mesh).volume_m3},
          {"area_m2", mesh::surface_area_m2(closed.mesh)}};
}

/// Count, errors and force.
nlohmann::json level_fields(const Decomposition& level, const Feel& feel, const Press& press) {
  return {{"balls", level.balls.size()},
          {"hausdorff_m", level.hausdorff_m},
          {"mesh_to_union_m", level.mesh_to_union_m},
          {"union_to_mesh_m", level.union_to_mesh_m},
          {"force", force_fields(press, feel)}};
}

}  // namespace

std::vector<Feel> feels_of(std::span<const Decomposition> levels, const mesh::TriangleMesh& closed,
                           const Press& press) {
  const mesh::MeshDistance distance(closed);
  std::vector<Feel> feels;
  for (const Decomposition& level : levels) feels.push_back(feel_of(level.balls, distance, press));
  return feels;
}

nlohmann::json report_fields(const mesh::TriangleMesh& read, const mesh::ClosedMesh& closed,
                             const Fineness& fineness, std::span<const Decomposition> levels,
                             std::span<const Feel> feels, const Press& press, double time_s) {
  nlohmann::json json = {
      {"mesh", mesh_fields(read, closed)}, {"levels", nlohmann::json::array()}, {"time_s", time_s}};
  // What was asked for, under the name that a scene has for it.
  if (fineness.tolerance_m > 0.0) json["tolerance_m"] = fineness.tolerance_m;
  if (fineness.surface_spacing_m > 0.0) json["surface_spacing_m"] = fineness.surface_spacing_m;
  if (fineness.volume_spacing_m > 0.0) json["volume_spacing_m"] = fineness.volume_spacing_m;
  for (std::size_t i = 0; i < levels.size(); ++i)
    json["levels"].push_back(level_fields(levels[i], feels[i], press));
  return json;
}

nlohmann::json search_fields(double share, std::span<const FeltLevel> levels) {
  nlohmann::json searched = nlohmann::json::array();
  for (const FeltLevel& level : levels)
    searched.push_back({{"balls", level.balls.size()},
                        {level.is_even ? "surface_spacing_m" : "tolerance_m", level.fineness_m},
                        {"error_share", level.error.share},
                        {"error_jnd", level.error.jnd()}});
  return {{"asked_share", share}, {"searched", std::move(searched)}};
}

}  // namespace stillgrid::spheres
