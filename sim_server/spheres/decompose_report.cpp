#include "sim_server/spheres/decompose_report.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim_server/mesh/mass_properties.hpp"
#include "sim_server/spheres/decomposition_error.hpp"
#include "sim_server/spheres/force_map.hpp"

namespace stillgrid::spheres {
namespace {

/// Forces for a contact stiffness of 1 N/m.
nlohmann::json force_fields(const Press& press, const BallBody& body) {
  const ForceMap map =
      map_force(press.surface, press.tool_radius_m, press.depth_m,
                [&](const Eigen::Vector3d& tool_m) { return unit_force_m(body, tool_m); });
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
          {"stiffness_scale", map.effective_stiffness > 0.0
                                  ? nlohmann::json(1.0 / map.effective_stiffness)
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
nlohmann::json level_fields(const Decomposition& level, const Press& press) {
  return {{"balls", level.balls.size()},
          {"hausdorff_m", level.hausdorff_m},
          {"mesh_to_union_m", level.mesh_to_union_m},
          {"union_to_mesh_m", level.union_to_mesh_m},
          {"force", force_fields(press, make_ball_body(level.balls, press.tool_radius_m))}};
}

}  // namespace

Press make_press(const mesh::TriangleMesh& closed, double tool_radius_m, double press_depth_m,
                 double tolerance_m) {
  constexpr std::size_t kSamples = 6000;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex_m : closed.vertices_m) box.extend(vertex_m);
  const auto given_or = [](double given_m, double otherwise_m) {
    return given_m > 0.0 ? given_m : otherwise_m;
  };
  const double radius_m = given_or(tool_radius_m, 0.02 * box.diagonal().norm());
  const double quarter_m = 0.25 * radius_m;
  const double depth_m =
      given_or(press_depth_m, std::min(quarter_m, given_or(tolerance_m, quarter_m)));
  const mesh::MeshDistance distance(closed);
  SurfaceSamples reachable =
      reachable_samples(sample_surface(closed, kSamples), distance, radius_m, depth_m);
  if (reachable.points_m.empty())
    throw std::runtime_error("--tool-radius " + std::to_string(radius_m) +
                             ": expected one that fits somewhere on the mesh");
  return {std::move(reachable), radius_m, depth_m};
}

nlohmann::json report_fields(const mesh::TriangleMesh& read, const mesh::ClosedMesh& closed,
                             const Fineness& fineness, std::span<const Decomposition> levels,
                             const Press& press, double time_s) {
  nlohmann::json json = {
      {"mesh", mesh_fields(read, closed)}, {"levels", nlohmann::json::array()}, {"time_s", time_s}};
  // What was asked for, under the name that a scene has for it.
  if (fineness.tolerance_m > 0.0) json["tolerance_m"] = fineness.tolerance_m;
  if (fineness.surface_spacing_m > 0.0) json["surface_spacing_m"] = fineness.surface_spacing_m;
  if (fineness.volume_spacing_m > 0.0) json["volume_spacing_m"] = fineness.volume_spacing_m;
  for (const Decomposition& level : levels) json["levels"].push_back(level_fields(level, press));
  return json;
}

}  // namespace stillgrid::spheres
