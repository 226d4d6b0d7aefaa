#include "tests/sim_server/spheres/recorded_contact.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "sim_server/mesh/mesh_file.hpp"
#include "sim_server/mesh/mesh_repair.hpp"
#include "sim_server/spheres/sampling.hpp"

namespace stillgrid::spheres::recorded_contact_test {
namespace {

/// How far the normal of whichever face is nearest goes with the measured force.
double nearest_face_cosine(const RecordedContact& recorded, const mesh::TriangleMesh& mesh,
                           const mesh::MeshDistance& distance) {
  return agreement(
             recorded,
             [&](const Eigen::Vector3d& tool_m) -> Eigen::Vector3d {
               const auto triangle = static_cast<std::size_t>(distance.closest(tool_m).triangle);
               const auto corner_m = [&](int i) {
                 return mesh.vertices_m[static_cast<std::size_t>(mesh.triangles[triangle][i])];
               };
               return (corner_m(1) - corner_m(0)).cross(corner_m(2) - corner_m(0));
             })
      .mean_cosine;
}

TEST_CASE(
    "Where people pressed a tool along an edge we push it, and more as they felt it than the "
    "nearest face does",
    "[real_data]") {
  const auto data = real_data();
  if (!data) {
    WARN("skipped: no recordings of a contour");
    return;
  }
  const mesh::TriangleMesh mesh =
      mesh::make_closed(mesh::load_mesh(*data / "meshes" / "ku_contour.stl", 1e-3),
                        "ku_contour.stl")
          .mesh;
  const mesh::MeshDistance distance(mesh);
  const BallBody balls = make_ball_body(firm_surface_balls(mesh, 0.004), kRecordedTool_m);

  for (const RecordedContact& recorded : read_contour_demonstrations(*data)) {
    CAPTURE(recorded.name);
    const ContactAgreement ours = agreement(
        recorded, [&](const Eigen::Vector3d& tool_m) { return unit_force_m(balls, tool_m); });
    CHECK(ours.share_in_contact > 0.95);
    CHECK(ours.mean_cosine > nearest_face_cosine(recorded, mesh, distance));
    CHECK(ours.mean_cosine > 0.82);
  }
}

}  // namespace
}  // namespace stillgrid::spheres::recorded_contact_test
