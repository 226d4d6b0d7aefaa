#include "tests/performance/blob_fit.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "sim_server/spheres/force_map.hpp"
#include "tests/sim_server/spheres/torus.hpp"

namespace stillgrid::performance {
namespace {

constexpr double kTool_m = 0.006;
constexpr double kDepth_m = 0.0015;

std::vector<DistanceTarget> torus_targets(std::size_t count) {
  const spheres::SurfaceSamples samples = spheres::torus_samples(count);
  std::vector<DistanceTarget> targets;
  for (std::size_t i = 0; i < count; ++i)
    for (const double out_m : {0.0, 0.5 * kTool_m, kTool_m}) {
      const Eigen::Vector3d point_m = samples.points_m[i] + out_m * samples.normals[i];
      targets.push_back({point_m, spheres::torus_distance_m(point_m)});
    }
  return targets;
}

spheres::ForceMap map_of(const BlobBody& body) {
  return spheres::map_force(
      spheres::torus_samples(3001), kTool_m, kDepth_m,
      [&](const Eigen::Vector3d& tool_m) { return unit_blob_force_m(body, kTool_m, tool_m); });
}
spheres::ForceMap map_of(const std::vector<spheres::Ball>& balls) {
  const spheres::BallBody body = spheres::make_ball_body(balls, kTool_m);
  return spheres::map_force(
      spheres::torus_samples(3001), kTool_m, kDepth_m,
      [&](const Eigen::Vector3d& tool_m) { return spheres::unit_force_m(body, tool_m); });
}

TEST_CASE("Blobs ripple a fifth of the balls they are made of, and have none of their holes",
          "[blobs]") {
  const int count = GENERATE(20, 40, 80);
  const spheres::ForceMap balls = map_of(spheres::torus_balls(count));
  const spheres::ForceMap blobs =
      map_of(fit_blobs(spheres::torus_balls(count), torus_targets(1500), kTool_m));
  CHECK(blobs.ripple < 0.2 * balls.ripple);
  CHECK(blobs.hole_share == 0.0);
  CHECK(blobs.min_over_max > 0.3);
  if (count == 20) CHECK(balls.hole_share > 0.3);
}

TEST_CASE("Blobs are as stiff as their material, however many", "[blobs]") {
  const int count = GENERATE(40, 80, 160);
  const spheres::ForceMap blobs =
      map_of(fit_blobs(spheres::torus_balls(count), torus_targets(1500), kTool_m));
  CHECK(blobs.effective_stiffness == Approx(1.0).epsilon(0.1));
  CHECK(blobs.mean_m == Approx(kDepth_m).epsilon(0.1));
}

TEST_CASE("Each finer level of blobs is nearer to the surface", "[blobs]") {
  double before_m = 1.0;
  for (const int count : {10, 20, 40, 80}) {
    const auto targets = torus_targets(1500);
    const double rms_m =
        blob_fit(fit_blobs(spheres::torus_balls(count), targets, kTool_m), targets).rms_m;
    CHECK(rms_m < 0.5 * before_m);
    before_m = rms_m;
  }
}

TEST_CASE("A sphere needs one blob", "[blobs]") {
  const std::vector<spheres::Ball> rough{{{0.001, 0.0, -0.001}, 0.048}};
  std::vector<DistanceTarget> targets;
  for (int i = 0; i < 50; ++i) {
    const double z = (i + 0.5) / 25.0 - 1.0, angle = 2.4 * i;
    const Eigen::Vector3d direction(std::sqrt(1.0 - z * z) * std::cos(angle),
                                    std::sqrt(1.0 - z * z) * std::sin(angle), z);
    targets.push_back({(0.05 + 0.003 * (i % 3)) * direction, 0.003 * (i % 3)});
  }
  const BlobBody body = fit_blobs(rough, targets, kTool_m);
  CHECK(blob_fit(body, targets).max_m < 1e-7);
  CHECK(body.balls[0].radius_m == Approx(0.05).epsilon(1e-6));
}

}  // namespace
}  // namespace stillgrid::performance
