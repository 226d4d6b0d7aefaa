#include "sim_server/spheres/effective_stiffness.hpp"

#include <catch2/catch.hpp>

#include "sim_server/spheres/force_map.hpp"
#include "tests/sim_server/spheres/torus.hpp"

namespace stillgrid::spheres::effective_stiffness_test {
namespace {

constexpr double kTool_m = 0.006;
constexpr double kDepth_m = 0.003;

double mean_force_m(const std::vector<Ball>& balls) {
  const BallBody body = make_ball_body(balls, kTool_m);
  return map_force(torus_samples(5000), kTool_m, kDepth_m,
                   [&](const Eigen::Vector3d& tool_m) { return unit_force_m(body, tool_m); })
      .mean_m;
}

TEST_CASE("One ball is as stiff as its contact", "[effective_stiffness]") {
  const std::vector<Ball> ball{{{0.1, 0.2, 0.3}, 0.05}};
  SurfaceSamples surface;
  surface.normals = {Eigen::Vector3d::UnitX(), Eigen::Vector3d(1, -2, 2).normalized()};
  for (const Eigen::Vector3d& normal : surface.normals)
    surface.points_m.push_back(ball[0].centre_m + ball[0].radius_m * normal);
  CHECK(effective_stiffness(ball, surface, 0.01, 0.004) == Approx(1.0));
  CHECK(stiffness_scale(ball, surface, 0.01, 0.004) == Approx(1.0));
}

TEST_CASE("A torus of four times the balls hardens, but not where it is normalised",
          "[effective_stiffness]") {
  const SurfaceSamples surface = torus_samples(5000);
  const std::vector<Ball> coarse = torus_balls(100), fine = torus_balls(400);
  const double plain = mean_force_m(fine) / mean_force_m(coarse);
  CHECK(plain > 3.9);
  CHECK(plain < 4.2);
  const double normalised = plain * stiffness_scale(fine, surface, kTool_m, kDepth_m) /
                            stiffness_scale(coarse, surface, kTool_m, kDepth_m);
  CHECK(normalised == Approx(1.0).epsilon(0.03));
}

TEST_CASE("Balls that a press does not reach cannot be normalised", "[effective_stiffness]") {
  std::vector<Ball> shrunk = torus_balls(100);
  for (Ball& ball : shrunk) ball.radius_m -= 2.0 * kDepth_m;
  CHECK_THROWS_WITH(stiffness_scale(shrunk, torus_samples(100), kTool_m, kDepth_m),
                    Catch::Contains("press_depth_m = 0.003") && Catch::Contains("100 balls"));
}

}  // namespace
}  // namespace stillgrid::spheres::effective_stiffness_test
