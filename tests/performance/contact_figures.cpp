// Recorded contact against ours: prints docs/charts/ku_contact.csv. Needs
// the folder of real inputs.
#include <Eigen/Geometry>
#include <cstdio>

#include "shared/tools/laboratory/blobs/blob_fit.hpp"
#include "sim_server/mesh/mesh_file.hpp"
#include "sim_server/mesh/mesh_repair.hpp"
#include "sim_server/spheres/decomposition.hpp"
#include "sim_server/spheres/sampling.hpp"
#include "tests/sim_server/spheres/recorded_contact.hpp"

namespace stillgrid {
namespace {

void print_agreement(const char* model, double tolerance_m, std::size_t balls, double error_m,
                     const std::vector<RecordedContact>& demonstrations, const UnitForce& force) {
  for (const RecordedContact& recorded : demonstrations) {
    const ContactAgreement found = agreement(recorded, force);
    std::printf("%s,%g,%zu,%.4g,%s,%.5f,%.5f\n", model, 1e3 * tolerance_m, balls, 1e3 * error_m,
                recorded.name.c_str(), found.share_in_contact, found.mean_cosine);
  }
  std::fflush(stdout);
}

void compare(const std::filesystem::path& data) {
  constexpr std::size_t kSamples = 6000;
  const auto demonstrations = read_contour_demonstrations(data);
  const TriangleMesh mesh =
      make_closed(load_mesh(data / "meshes" / "ku_contour.stl", 1e-3), "ku_contour.stl").mesh;
  const MeshDistance distance(mesh);
  std::printf("# tool radius %g mm\n", 1e3 * kRecordedTool_m);
  std::printf("model,step_mm,balls,error_mm,demonstration,in_contact,mean_cosine\n");

  // Everywhere in contact, pushed along the normal of whichever face is nearest.
  print_agreement("nearest face", 0.0, 0, 0.0, demonstrations,
                  [&](const Eigen::Vector3d& tool_m) -> Eigen::Vector3d {
                    const NearestPoint point = distance.closest(tool_m);
                    const auto corner_m = [&](int i) {
                      const auto triangle = static_cast<std::size_t>(point.triangle);
                      return mesh.vertices_m[static_cast<std::size_t>(mesh.triangles[triangle][i])];
                    };
                    return (corner_m(1) - corner_m(0)).cross(corner_m(2) - corner_m(0));
                  });
  for (const double spacing_m : {0.008, 0.004, 0.002}) {
    const std::vector<Ball> even = surface_balls(mesh, spacing_m, spacing_m);
    const BallBody balls = make_ball_body(even, kRecordedTool_m);
    print_agreement("even spheres", spacing_m, even.size(), 0.0, demonstrations,
                    [&](const Eigen::Vector3d& tool_m) { return unit_force_m(balls, tool_m); });
  }
  const auto targets = distance_targets(sample_surface(mesh, kSamples), distance, kRecordedTool_m);
  for (const double tolerance_m : {0.008, 0.004}) {
    const Decomposition made = decompose(mesh, tolerance_m);
    const BallBody balls = make_ball_body(made.balls, kRecordedTool_m);
    print_agreement("spheres", tolerance_m, made.balls.size(), made.hausdorff_m, demonstrations,
                    [&](const Eigen::Vector3d& tool_m) { return unit_force_m(balls, tool_m); });
    const BlobBody blobs = fit_blobs(made.balls, targets, kRecordedTool_m);
    print_agreement("blobs", tolerance_m, blobs.balls.size(), blob_fit(blobs, targets).rms_m,
                    demonstrations, [&](const Eigen::Vector3d& tool_m) {
                      return unit_blob_force_m(blobs, kRecordedTool_m, tool_m);
                    });
  }
}

}  // namespace
}  // namespace stillgrid

int main() {
  const auto data = stillgrid::real_data();
  if (!data) {
    std::fprintf(stderr, "contact_figures: expected $STILLGRID_DATA or ../shared/data\n");
    return 1;
  }
  stillgrid::compare(*data);
}
