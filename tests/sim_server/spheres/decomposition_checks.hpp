#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "sim_server/mesh/mesh_distance.hpp"
#include "sim_server/spheres/decomposition.hpp"
#include "sim_server/spheres/surface_samples.hpp"

namespace stillgrid::spheres {

/// How far a point is from the union of balls, less than 0 inside.
inline double outside_all_m(const std::vector<Ball>& balls, const Eigen::Vector3d& point_m) {
  double least_m = std::numeric_limits<double>::infinity();
  for (const Ball& ball : balls)
    least_m = std::min(least_m, (point_m - ball.centre_m).norm() - ball.radius_m);
  return least_m;
}

/// The two-sided distance measured anew, by samples: never above the truth but where a sample of
/// the mesh is inside the union; there by at most the spacing of those on the union.
inline double sampled_hausdorff_m(const mesh::TriangleMesh& mesh, const std::vector<Ball>& balls) {
  const mesh::MeshDistance distance(mesh);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  double farthest_m = 0.0;
  for (const Ball& ball : balls)
    for (int i = 0; i < 1500; ++i) {
      const Eigen::Vector3d direction =
          Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
      const Eigen::Vector3d point_m = ball.centre_m + ball.radius_m * direction;
      if (outside_all_m(balls, point_m) < -1e-12) continue;
      farthest_m = std::max(farthest_m, std::abs(distance.signed_distance_m(point_m)));
    }
  for (const Eigen::Vector3d& point_m : sample_surface(mesh, 10'000).points_m)
    farthest_m = std::max(farthest_m, std::abs(outside_all_m(balls, point_m)));
  return farthest_m;
}

/// What holds for every decomposition.
inline void check_decomposition(const mesh::TriangleMesh& mesh, const Decomposition& result,
                                double tolerance_m) {
  CHECK(result.hausdorff_m <= tolerance_m);
  const double sampled_m = sampled_hausdorff_m(mesh, result.balls);
  CHECK(sampled_m <= result.hausdorff_m);
  CHECK(sampled_m > 0.5 * result.hausdorff_m);  // the bound is near the truth
  const mesh::MeshDistance distance(mesh);
  for (const Ball& ball : result.balls)
    CHECK(ball.radius_m <= -distance.signed_distance_m(ball.centre_m) + tolerance_m);
}

}  // namespace stillgrid::spheres
