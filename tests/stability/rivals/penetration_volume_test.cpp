#include "tests/laboratory/rivals/penetration_volume.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "tests/sim_server/spheres/torus.hpp"

namespace stillgrid::laboratory::penetration_volume_test {
namespace {

using Random = std::mt19937;

Eigen::Vector3d anywhere(Random& random) {
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  return {any(random), any(random), any(random)};
}

/// Two spheres that overlap, one perhaps within the other.
std::array<spheres::Ball, 2> overlapping(Random& random) {
  std::uniform_real_distribution<double> radius_m(0.002, 0.03), share(0.03, 0.999);
  const spheres::Ball a{0.1 * anywhere(random), radius_m(random)};
  const double other_m = radius_m(random);
  return {a,
          {a.centre_m + share(random) * (a.radius_m + other_m) * anywhere(random).normalized(),
           other_m}};
}

/// Volume and centroid as sums over slices across the line of the centres.
SphereOverlap sliced(const spheres::Ball& a, const spheres::Ball& b) {
  constexpr int kSlices = 200000;
  const double distance_m = (b.centre_m - a.centre_m).norm();
  const double low_m = std::max(-a.radius_m, distance_m - b.radius_m),
               high_m = std::min(a.radius_m, distance_m + b.radius_m),
               step_m = (high_m - low_m) / kSlices;
  double volume_m3 = 0.0, moment_m4 = 0.0;
  for (int i = 0; i < kSlices; ++i) {
    const double x_m = low_m + (i + 0.5) * step_m, from_b_m = x_m - distance_m;
    const double slice_m3 = std::numbers::pi * step_m *
                            std::min(a.radius_m * a.radius_m - x_m * x_m,
                                     b.radius_m * b.radius_m - from_b_m * from_b_m);
    volume_m3 += slice_m3;
    moment_m4 += x_m * slice_m3;
  }
  return {volume_m3, a.centre_m + moment_m4 / volume_m3 * (b.centre_m - a.centre_m) / distance_m};
}

double volume_at_m3(const spheres::Ball& a, double radius_m, double distance_m) {
  return overlap_of(a, {a.centre_m + distance_m * Eigen::Vector3d(2, -1, 2) / 3.0, radius_m})
      .volume_m3;
}

VolumeBody lone(const spheres::Ball& ball, double tool_m) {
  return {spheres::make_ball_body(std::array{ball}, tool_m), 1e5};
}

TEST_CASE("The volume and the centroid of two spheres' overlap are those of its slices",
          "[penetration_volume]") {
  Random random(GENERATE(1U, 2U, 3U));
  for (int i = 0; i < 40; ++i) {
    const auto [a, b] = overlapping(random);
    CAPTURE(a.radius_m, b.radius_m, (a.centre_m - b.centre_m).norm());
    const SphereOverlap closed = overlap_of(a, b), by_slices = sliced(a, b);
    CHECK(closed.volume_m3 == Approx(by_slices.volume_m3).epsilon(1e-7));
    CHECK((closed.centroid_m - by_slices.centroid_m).norm() < 1e-8);
    const SphereOverlap other_way = overlap_of(b, a);
    CHECK(other_way.volume_m3 == Approx(closed.volume_m3).epsilon(1e-12));
    CHECK((other_way.centroid_m - closed.centroid_m).norm() < 1e-14);
  }
}

TEST_CASE(
    "An overlap shrinks by the disc between the spheres as they part, without a step at "
    "touch or where one is within the other",
    "[penetration_volume]") {
  Random random(GENERATE(4U, 5U, 6U));
  for (int i = 0; i < 100; ++i) {
    const auto [a, b] = overlapping(random);
    const double distance_m = (a.centre_m - b.centre_m).norm(), step_m = 1e-4 * b.radius_m;
    const double along_m =
        (distance_m * distance_m + a.radius_m * a.radius_m - b.radius_m * b.radius_m) /
        (2.0 * distance_m);
    const double disc_m2 =
        std::numbers::pi * std::max(0.0, a.radius_m * a.radius_m - along_m * along_m);
    const double slope_m2 = (volume_at_m3(a, b.radius_m, distance_m + step_m) -
                             volume_at_m3(a, b.radius_m, distance_m - step_m)) /
                            (2.0 * step_m);
    CHECK(slope_m2 == Approx(-disc_m2).margin(2e-3 * std::numbers::pi * b.radius_m * b.radius_m));
    for (const double border_m : {a.radius_m + b.radius_m, std::abs(a.radius_m - b.radius_m)}) {
      constexpr double kHair_m = 1e-9;
      if (border_m < 2.0 * kHair_m) continue;
      CHECK(volume_at_m3(a, b.radius_m, border_m - kHair_m) ==
            Approx(volume_at_m3(a, b.radius_m, border_m + kHair_m)).margin(1e-13));
    }
    CHECK(volume_at_m3(a, b.radius_m, (1.0 + 1e-12) * (a.radius_m + b.radius_m)) == 0.0);
  }
}

TEST_CASE(
    "A sphere within another overlaps it with all of itself; none pushes centre on centre, "
    "or where a number is none",
    "[penetration_volume]") {
  const spheres::Ball large{{0.3, 0.1, -0.2}, 0.02}, small{{0.305, 0.102, -0.201}, 0.004};
  const double small_m3 = 4.0 / 3.0 * std::numbers::pi * std::pow(small.radius_m, 3);
  CHECK(overlap_of(large, small).volume_m3 == Approx(small_m3).epsilon(1e-14));
  CHECK(overlap_of(large, small).centroid_m == small.centre_m);
  CHECK(unit_volume_force_m(lone(large, 0.004), small.centre_m).norm() ==
        Approx(1e5 * small_m3).epsilon(1e-12));
  CHECK(unit_volume_force_m(lone(large, 0.004), large.centre_m).isZero(0.0));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(overlap_of(large, {{nan, 0.0, 0.0}, 0.01}).volume_m3 == 0.0);
  CHECK(overlap_of(large, {{0.3, 0.1, -0.2}, nan}).volume_m3 == 0.0);
}

TEST_CASE("Two spheres push each other alike and oppositely, with opposite moments",
          "[penetration_volume]") {
  Random random(GENERATE(7U, 8U, 9U));
  constexpr collision::ContactMaterial kSpring{.stiffness_N_per_m = 700.0};
  for (int i = 0; i < 100; ++i) {
    const auto [a, b] = overlapping(random);
    const auto on = [&](const spheres::Ball& pushed, const spheres::Ball& pushing) {
      return volume_force(lone(pushing, pushed.radius_m), kSpring,
                          std::array{rendering::PlacedToolSphere{pushed.centre_m, pushed.radius_m,
                                                                 pushed.centre_m}},
                          {.position_m = Eigen::Vector3d::Zero()});
    };
    const rendering::ToolForce on_a = on(a, b), on_b = on(b, a);
    REQUIRE(on_a.contacts == 1);
    CHECK(on_a.force_N.norm() > 0.0);
    CHECK((on_a.force_N + on_b.force_N).norm() < 1e-12 * on_a.force_N.norm());
    CHECK((on_a.torque_N_m + on_b.torque_N_m).norm() < 1e-12 * on_a.force_N.norm());
    CHECK(on_a.force_N.dot(a.centre_m - b.centre_m) > 0.0);
  }
}

/// A tool of three spheres of different sizes, placed where it overlaps a torus of balls.
struct Tool {
  std::array<rendering::PlacedToolSphere, 3> spheres;
  rendering::ToolPose pose;
};
Tool some_tool(Random& random, const spheres::SurfaceSamples& samples) {
  const std::size_t at = random() % samples.points_m.size();
  const Eigen::Vector3d first_m = samples.points_m[at] + 0.004 * samples.normals[at];
  Tool tool;
  tool.pose = {.position_m = first_m + 0.05 * anywhere(random)};
  const std::array<double, 3> radii_m = {0.006, 0.0041, 0.0023};
  for (std::size_t i = 0; i < radii_m.size(); ++i) {
    const Eigen::Vector3d centre_m = first_m + (i == 0 ? 0.0 : 0.005) * anywhere(random);
    tool.spheres[i] = {centre_m, radii_m[i], centre_m};
  }
  return tool;
}

TEST_CASE(
    "Force and torque on a tool of several spheres are those of a pressure field over every "
    "overlap",
    "[penetration_volume]") {
  Random random(GENERATE(10U, 11U, 12U));
  const auto balls = spheres::torus_balls(30);
  const spheres::SurfaceSamples samples = spheres::torus_samples(200);
  const VolumeBody body = make_volume_body(balls, samples, 0.006, 0.0015);
  constexpr collision::ContactMaterial kSpring{.stiffness_N_per_m = 420.0};
  for (int i = 0; i < 10; ++i) {
    const Tool tool = some_tool(random, samples);
    Eigen::Vector3d force_N = Eigen::Vector3d::Zero(), torque_N_m = Eigen::Vector3d::Zero();
    for (const rendering::PlacedToolSphere& probe : tool.spheres)
      for (const spheres::Ball& ball : balls) {
        const Eigen::Vector3d apart_m = probe.position_m - ball.centre_m;
        if (apart_m.norm() >= ball.radius_m + probe.radius_m) continue;
        const SphereOverlap overlap = sliced(ball, {probe.position_m, probe.radius_m});
        const Eigen::Vector3d push_N =
            420.0 * body.pressure_per_m2 * overlap.volume_m3 * apart_m.normalized();
        force_N += push_N;
        torque_N_m += (overlap.centroid_m - tool.pose.position_m).cross(push_N);
      }
    const rendering::ToolForce found = volume_force(body, kSpring, tool.spheres, tool.pose);
    REQUIRE(found.contacts > 0);
    CHECK((found.force_N - force_N).norm() < 1e-6 * force_N.norm());
    CHECK((found.torque_N_m - torque_N_m).norm() < 1e-6 * 0.05 * force_N.norm());
  }
}

TEST_CASE("A closed path through overlapping balls, deep and turning, takes and gives no work",
          "[penetration_volume]") {
  Random random(GENERATE(13U, 14U, 15U));
  const spheres::SurfaceSamples samples = spheres::torus_samples(200);
  const VolumeBody body = make_volume_body(spheres::torus_balls(40), samples, 0.006, 0.0015);
  constexpr int kSteps = 20000;
  const Eigen::Vector3d centre_m = samples.points_m[random() % 200], sideways = anywhere(random),
                        across = anywhere(random);
  const auto at_m = [&](int step) -> Eigen::Vector3d {
    const double angle = 2.0 * std::numbers::pi * step / kSteps;
    return centre_m + 0.012 * (std::cos(angle) * sideways + std::sin(2.0 * angle) * across);
  };
  double work_m2 = 0.0, moved_m2 = 0.0;
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::Vector3d way_m = at_m(step + 1) - at_m(step);
    const double one_m2 = unit_volume_force_m(body, 0.5 * (at_m(step) + at_m(step + 1))).dot(way_m);
    work_m2 += one_m2;
    moved_m2 += std::abs(one_m2);
  }
  REQUIRE(moved_m2 > 0.0);
  CHECK(std::abs(work_m2) < 1e-6 * moved_m2);
}

TEST_CASE(
    "A body that pushes by volume is as stiff as its material, and two balls in one place "
    "push twice",
    "[penetration_volume]") {
  const int count = GENERATE(20, 60);
  const auto balls = spheres::torus_balls(count);
  const spheres::SurfaceSamples samples = spheres::torus_samples(500);
  const double tool_m = 0.006, depth_m = GENERATE(0.001, 0.0023);
  const VolumeBody body = make_volume_body(balls, samples, tool_m, depth_m);
  const auto force = [&](const Eigen::Vector3d& at_m) { return unit_volume_force_m(body, at_m); };
  CHECK(spheres::map_force(samples, tool_m, depth_m, force).effective_stiffness ==
        Approx(1.0).epsilon(1e-9));

  auto doubled = balls;
  doubled.insert(doubled.end(), balls.begin(), balls.end());
  const VolumeBody twice{spheres::make_ball_body(doubled, tool_m), body.pressure_per_m2};
  double most_m = 0.0;
  for (std::size_t i = 0; i < samples.points_m.size(); ++i) {
    const Eigen::Vector3d at_m = samples.points_m[i] + (tool_m - depth_m) * samples.normals[i];
    CHECK((unit_volume_force_m(twice, at_m) - 2.0 * force(at_m)).norm() < 1e-12);
    most_m = std::max(most_m, force(at_m).norm());
  }
  CHECK(most_m > 0.1 * depth_m);
}

TEST_CASE("A damper and friction act at the overlap's centroid as the contact law has them",
          "[penetration_volume]") {
  const spheres::Ball ball{Eigen::Vector3d::Zero(), 0.02};
  const VolumeBody body = lone(ball, 0.005);
  constexpr collision::ContactMaterial kMaterial{.stiffness_N_per_m = 500.0,
                                                 .damping_N_s_per_m = 3.0,
                                                 .friction = 0.4,
                                                 .slip_speed_m_s = 0.01};
  const Eigen::Vector3d centre_m(0.0, 0.0, 0.023);
  const std::array tool{rendering::PlacedToolSphere{centre_m, 0.005, centre_m}};
  const rendering::ToolPose pose{.position_m = {0.0, 0.0, 0.1},
                                 .velocity_m_s = {0.0, 0.0, -0.05},
                                 .angular_velocity_rad_s = {0.7, 0.0, 0.0}};
  const SphereOverlap overlap = overlap_of(ball, {centre_m, 0.005});
  const double normal_N = 500.0 * 1e5 * overlap.volume_m3 + 3.0 * 0.05;
  const double slip_m_s = 0.7 * (0.1 - overlap.centroid_m.z());
  const rendering::ToolForce found = volume_force(body, kMaterial, tool, pose);
  CHECK(found.force_N.z() == Approx(normal_N).epsilon(1e-12));
  CHECK(found.force_N.y() ==
        Approx(-0.4 * normal_N * std::min(1.0, slip_m_s / 0.01)).epsilon(1e-12));
  CHECK(found.torque_N_m.x() ==
        Approx((0.1 - overlap.centroid_m.z()) * found.force_N.y()).epsilon(1e-12));
}

}  // namespace
}  // namespace stillgrid::laboratory::penetration_volume_test
