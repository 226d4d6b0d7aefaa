#include "tests/performance/blobs.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "tests/sim_server/spheres/torus.hpp"

namespace stillgrid::performance {
namespace {

constexpr double kTool_m = 0.006;
constexpr double kSoftness_m = 0.002;

double energy_m2(const BlobBody& body, const Eigen::Vector3d& tool_m) {
  const double depth_m = std::max(0.0, kTool_m - sample_blobs(body, tool_m).distance_m);
  return 0.5 * depth_m * depth_m;
}

/// Central difference of a field.
template <class Field>
Eigen::Vector3d slope_of(const Field& field, const Eigen::Vector3d& point_m) {
  constexpr double kStep_m = 1e-6;
  Eigen::Vector3d slope;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step_m = kStep_m * Eigen::Vector3d::Unit(axis);
    slope[axis] = (field(point_m + step_m) - field(point_m - step_m)) / (2.0 * kStep_m);
  }
  return slope;
}

TEST_CASE("A single blob is its ball: distance and force exact", "[blobs]") {
  const std::vector<spheres::Ball> ball{{{0.1, -0.2, 0.3}, 0.05}};
  const BlobBody body = make_blob_body(ball, kSoftness_m, kTool_m);
  const Eigen::Vector3d direction = Eigen::Vector3d(2, -1, 2).normalized();
  const double distance_m = GENERATE(-0.03, -0.001, 0.0, 0.004, 0.012);
  const BlobSample sample = sample_blobs(body, ball[0].centre_m + (0.05 + distance_m) * direction);
  CHECK(sample.distance_m == Approx(distance_m).margin(1e-12));
  CHECK((sample.gradient - direction).norm() < 1e-12);
  CHECK((unit_blob_force_m(body, kTool_m, ball[0].centre_m + 0.054 * direction) - 0.002 * direction)
            .norm() < 1e-12);
}

TEST_CASE("The gradient of blobs is the slope of their distance, where terms fade too", "[blobs]") {
  const BlobBody body = make_blob_body(spheres::torus_balls(30), kSoftness_m, kTool_m);
  const spheres::SurfaceSamples samples = spheres::torus_samples(200);
  const double out_m = GENERATE(-0.01, 0.0, 0.003, 0.014, 0.018);
  for (std::size_t i = 0; i < 200; ++i) {
    const Eigen::Vector3d point_m = samples.points_m[i] + out_m * samples.normals[i];
    if (!std::isfinite(sample_blobs(body, point_m + 2e-6 * samples.normals[i]).distance_m))
      continue;
    const Eigen::Vector3d slope = slope_of(
        [&](const Eigen::Vector3d& at_m) { return sample_blobs(body, at_m).distance_m; }, point_m);
    CHECK((sample_blobs(body, point_m).gradient - slope).norm() < 1e-5 * (1.0 + slope.norm()));
  }
}

TEST_CASE("A blob's force is minus the slope of an energy, so no closed path gives work",
          "[blobs]") {
  const BlobBody body = make_blob_body(spheres::torus_balls(30), kSoftness_m, kTool_m);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const spheres::SurfaceSamples samples = spheres::torus_samples(50);
  for (std::size_t i = 0; i < 50; ++i) {
    const Eigen::Vector3d tool_m = samples.points_m[i] + 0.002 * samples.normals[i];
    const Eigen::Vector3d slope =
        slope_of([&](const Eigen::Vector3d& at_m) { return energy_m2(body, at_m); }, tool_m);
    CHECK((unit_blob_force_m(body, kTool_m, tool_m) + slope).norm() < 1e-8);
  }

  // A loop that dips in, runs along the body and comes out again.
  const Eigen::Vector3d centre_m = samples.points_m[7] + 0.004 * samples.normals[7];
  const Eigen::Vector3d across = Eigen::Vector3d(normal(random), normal(random), normal(random));
  constexpr int kSteps = 20000;
  double work_m2 = 0.0, spent_m2 = 0.0;
  const auto at_m = [&](int step) -> Eigen::Vector3d {
    const double angle = 2.0 * M_PI * step / kSteps;
    return centre_m +
           0.006 * (std::cos(angle) * samples.normals[7] + std::sin(angle) * across.normalized());
  };
  for (int step = 0; step < kSteps; ++step) {
    const double part_m2 = unit_blob_force_m(body, kTool_m, 0.5 * (at_m(step) + at_m(step + 1)))
                               .dot(at_m(step + 1) - at_m(step));
    work_m2 += part_m2;
    spent_m2 += std::abs(part_m2);
  }
  CHECK(std::abs(work_m2) < 1e-6 * spent_m2);
}

TEST_CASE("A blob's force is continuous along any path, through contact and out of reach",
          "[blobs]") {
  const BlobBody body = make_blob_body(spheres::torus_balls(12), kSoftness_m, kTool_m);
  constexpr double kStep_m = 1e-6;
  Eigen::Vector3d before_m = Eigen::Vector3d::Zero();
  for (int i = 0; i < 60000; ++i) {  // from outside through the tube to the middle of the ring
    const Eigen::Vector3d tool_m(0.16 - 2.0 * kStep_m * i, 0.013, 0.002);
    const Eigen::Vector3d now_m = unit_blob_force_m(body, kTool_m, tool_m);
    // The force is at most as steep as 1 + depth / radius of a blob + depth / softness.
    REQUIRE((now_m - before_m).norm() < 30.0 * 2.0 * kStep_m);
    before_m = now_m;
  }
}

TEST_CASE("Out of all blobs' reach, or at no place, there is no force", "[blobs]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const BlobBody body = make_blob_body(spheres::torus_balls(12), kSoftness_m, kTool_m);
  CHECK(std::isinf(sample_blobs(body, {1.0, 0.0, 0.0}).distance_m));
  CHECK(unit_blob_force_m(body, kTool_m, {1.0, 0.0, 0.0}).isZero(0.0));
  CHECK(unit_blob_force_m(body, kTool_m, {nan, 0.0, 0.0}).isZero(0.0));
  CHECK(unit_blob_force_m(body, kTool_m, {0.0, 0.0, 0.0}).isZero(0.0));  // through the hole
}

}  // namespace
}  // namespace stillgrid::performance
