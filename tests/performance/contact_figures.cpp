// Recorded contact against ours: prints docs/charts/ku_contact.csv. Needs
// the folder of real inputs.
#include <Eigen/Geometry>
#include <cstdio>

#include "sim_server/fields/field_force.hpp"
#include "sim_server/fields/mesh_field.hpp"
#include "sim_server/mesh/mesh_file.hpp"
#include "sim_server/mesh/mesh_repair.hpp"
#include "sim_server/spheres/decomposition.hpp"
#include "sim_server/spheres/felt_error.hpp"
#include "sim_server/spheres/sampling.hpp"
#include "tests/laboratory/rivals/penetration_volume.hpp"
#include "tests/sim_server/spheres/recorded_contact.hpp"

namespace stillgrid::performance {
namespace {

void print_agreement(const char* model, double tolerance_m, std::size_t balls, double error_m,
                     const std::vector<spheres::RecordedContact>& demonstrations,
                     const spheres::UnitForce& force) {
  for (const spheres::RecordedContact& recorded : demonstrations) {
    const spheres::ContactAgreement found = spheres::agreement(recorded, force);
    std::printf("%s,%g,%zu,%.4g,%s,%.5f,%.5f,%.5f\n", model, 1e3 * tolerance_m, balls,
                1e3 * error_m, recorded.name.c_str(), found.share_in_contact, found.mean_cosine,
                found.correlation);
  }
  std::fflush(stdout);
}

void compare(const std::filesystem::path& data) {
  const auto demonstrations = spheres::read_contour_demonstrations(data);
  const mesh::TriangleMesh mesh =
      mesh::make_closed(mesh::load_mesh(data / "meshes" / "ku_contour.stl", 1e-3), "ku_contour.stl")
          .mesh;
  const mesh::MeshDistance distance(mesh);
  std::printf("# tool radius %g mm\n", 1e3 * spheres::kRecordedTool_m);
  std::printf("model,step_mm,balls,error_mm,demonstration,in_contact,mean_cosine,correlation\n");

  print_agreement("nearest point", 0.0, 0, 0.0, demonstrations, [&](const Eigen::Vector3d& tool_m) {
    return spheres::exact_force_m(distance, tool_m, spheres::kRecordedTool_m);
  });
  for (const double cell_m : {0.008, 0.004, 0.002, 0.001}) {
    const collision::DistanceField field =
        fields::make_mesh_field(mesh, {cell_m, spheres::kRecordedTool_m, 0.01});
    print_agreement("field", cell_m, field.shape().fine_count, 0.0, demonstrations,
                    [&](const Eigen::Vector3d& tool_m) {
                      return fields::unit_force_m(field.view(), tool_m, spheres::kRecordedTool_m);
                    });
  }
  // Everywhere in contact, pushed along the normal of whichever face is nearest.
  print_agreement("nearest face", 0.0, 0, 0.0, demonstrations,
                  [&](const Eigen::Vector3d& tool_m) -> Eigen::Vector3d {
                    const mesh::NearestPoint point = distance.closest(tool_m);
                    const auto corner_m = [&](int i) {
                      const auto triangle = static_cast<std::size_t>(point.triangle);
                      return mesh.vertices_m[static_cast<std::size_t>(mesh.triangles[triangle][i])];
                    };
                    return (corner_m(1) - corner_m(0)).cross(corner_m(2) - corner_m(0));
                  });
  for (const double spacing_m : {0.008, 0.004, 0.002}) {
    const std::vector<spheres::Ball> even = spheres::firm_surface_balls(mesh, spacing_m);
    const spheres::BallBody balls = spheres::make_ball_body(even, spheres::kRecordedTool_m);
    print_agreement(
        "even spheres", spacing_m, even.size(), 0.0, demonstrations,
        [&](const Eigen::Vector3d& tool_m) { return spheres::unit_force_m(balls, tool_m); });
    // Direction alone is compared, so that the pressure does not matter.
    const laboratory::VolumeBody volume{balls, 1.0};
    print_agreement("penetration volume", spacing_m, even.size(), 0.0, demonstrations,
                    [&](const Eigen::Vector3d& tool_m) {
                      return laboratory::unit_volume_force_m(volume, tool_m);
                    });
  }
  for (const double tolerance_m : {0.008, 0.004}) {
    const spheres::Decomposition made = spheres::decompose(mesh, tolerance_m);
    const spheres::BallBody balls = spheres::make_ball_body(made.balls, spheres::kRecordedTool_m);
    print_agreement(
        "spheres", tolerance_m, made.balls.size(), made.hausdorff_m, demonstrations,
        [&](const Eigen::Vector3d& tool_m) { return spheres::unit_force_m(balls, tool_m); });
  }
}

}  // namespace
}  // namespace stillgrid::performance

int main() {
  const auto data = stillgrid::spheres::real_data();
  if (!data) {
    std::fprintf(stderr, "contact_figures: expected $STILLGRID_DATA or ../shared/data\n");
    return 1;
  }
  stillgrid::performance::compare(*data);
}
