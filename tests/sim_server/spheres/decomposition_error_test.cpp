#include "sim_server/spheres/decomposition_error.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "sim_server/spheres/sampling.hpp"
#include "tests/sim_server/mesh/solids.hpp"

namespace stillgrid::spheres::decomposition_error_test {
namespace {

constexpr double kPi = std::numbers::pi;

/// Balls of one radius round the middle line of a torus.
std::vector<Ball> ring_of_balls(double ring_m, double radius_m, int count) {
  std::vector<Ball> balls;
  for (int i = 0; i < count; ++i) {
    const double u = 2.0 * kPi * i / count;
    balls.push_back({{ring_m * std::cos(u), ring_m * std::sin(u), 0.0}, radius_m});
  }
  return balls;
}

TEST_CASE("Balls round a torus are as far from it as the formula says", "[decomposition_error]") {
  const double ring_m = 1.0, tube_m = 0.3;
  const MeshSolid solid(mesh::torus_mesh(ring_m, tube_m, 240, 48));
  const auto [count, error_m] = GENERATE(std::pair(10, 0.166104), std::pair(20, 0.0493));

  const Decomposition measured =
      with_error(solid, ring_of_balls(ring_m, tube_m, count), 0.04 * error_m);

  CHECK(measured.mesh_to_union_m ==
        Approx(error_m).margin(0.05 * error_m + 7e-4));  // the mesh is no torus
  // The gap between two balls is deepest on the torus's outside, where they are farthest apart.
  const double half_gap_m = ring_m * std::sin(kPi / count);
  if (half_gap_m < tube_m) {
    const double out_m =
        ring_m * std::cos(kPi / count) + std::sqrt(tube_m * tube_m - half_gap_m * half_gap_m);
    CHECK(measured.union_to_mesh_m ==
          Approx(ring_m + tube_m - out_m).margin(0.05 * error_m + 7e-4));
  }
  CHECK(measured.hausdorff_m == std::max(measured.mesh_to_union_m, measured.union_to_mesh_m));
}

TEST_CASE("A row of balls in a rod leaves the formula's gap and cusp", "[decomposition_error]") {
  const double radius_m = 0.2, step_m = 0.2;
  const MeshSolid solid(mesh::capsule_mesh(1.0, radius_m, 120, 30));
  std::vector<Ball> row;
  for (int i = 0; i <= 5; ++i) row.push_back({{0, 0, step_m * i - 0.5}, radius_m});

  const Decomposition measured = with_error(solid, row, 6e-4);

  const double half_squared_m2 = 0.25 * step_m * step_m;
  CHECK(measured.mesh_to_union_m ==
        Approx(std::sqrt(radius_m * radius_m + half_squared_m2) - radius_m).margin(7e-4));
  CHECK(measured.union_to_mesh_m ==
        Approx(radius_m - std::sqrt(radius_m * radius_m - half_squared_m2)).margin(7e-4));
}

TEST_CASE("A ball that sticks out is as far from the mesh as it sticks out",
          "[decomposition_error]") {
  const MeshSolid solid(mesh::ball_mesh(1.0, 120, 30));
  const double out_m = GENERATE(0.02, 0.1);
  const Decomposition measured = with_error(solid, {{{0, 0, 0}, 1.0 + out_m}}, 2e-3);
  CHECK(measured.mesh_to_union_m == Approx(out_m).margin(3e-3));
  CHECK(measured.union_to_mesh_m == Approx(out_m).margin(3e-3));
}

TEST_CASE("A hollow inside the union is found, however well the mesh is covered",
          "[decomposition_error]") {
  const mesh::TriangleMesh cube = mesh::cube_mesh();
  const MeshSolid solid(cube);
  std::vector<Ball> shell = volume_balls(cube, 0.125, 0.1);
  std::erase_if(shell, [](const Ball& ball) {
    return (ball.centre_m.array() > 0.125).all() && (ball.centre_m.array() < 0.875).all();
  });
  const Decomposition hollow = with_error(solid, shell, 5e-3);
  const Decomposition filled = with_error(solid, volume_balls(cube, 0.125, 0.12), 5e-3);
  CHECK(hollow.mesh_to_union_m < 0.1);
  CHECK(hollow.union_to_mesh_m > 0.125);
  CHECK(filled.union_to_mesh_m < 0.07);

  const TooFar far = find_too_far(solid, shell, 0.1, 0.02);
  CHECK_FALSE(far.hollows_m.empty());
  CHECK(far.uncovered.points_m.empty());
}

TEST_CASE("A lattice of balls covers a cube as the formulas say", "[decomposition_error]") {
  const mesh::TriangleMesh cube = mesh::cube_mesh();
  const MeshSolid solid(cube);
  const double root3 = std::sqrt(3.0);
  CHECK(with_error(solid, volume_balls(cube, 0.25, 0.125), 3e-3).mesh_to_union_m ==
        Approx((root3 - 1.0) / 8.0).margin(3.1e-3));
  const double balanced_m = 0.25 * kVolumeRadius;
  CHECK(with_error(solid, volume_balls(cube, 0.25, balanced_m), 3e-3).mesh_to_union_m ==
        Approx((root3 - 1.0) / 16.0).margin(3.1e-3));
  for (const Ball& ball : volume_balls(cube, 0.25, balanced_m))
    CHECK(ball.radius_m + solid.distance.signed_distance_m(ball.centre_m) <
          (root3 - 1.0) / 16.0 + 1e-12);
}

}  // namespace
}  // namespace stillgrid::spheres::decomposition_error_test
