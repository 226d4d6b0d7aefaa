#include "sim_server/spheres/decomposition_candidates.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>

namespace stillgrid::spheres {
namespace {

/// The first ball of each cell of a lattice of centres and radii.
std::vector<Ball> one_a_cell(const std::vector<Ball>& balls, double cell_m) {
  std::set<std::array<std::int64_t, 4>> taken;
  std::vector<Ball> kept;
  const auto cell = [&](double x_m) { return static_cast<std::int64_t>(std::floor(x_m / cell_m)); };
  for (const Ball& ball : balls)
    if (taken
            .insert({cell(ball.centre_m.x()), cell(ball.centre_m.y()), cell(ball.centre_m.z()),
                     cell(ball.radius_m)})
            .second)
      kept.push_back(ball);
  return kept;
}

}  // namespace

Ball medial_ball(const MeshSolid& solid, const Eigen::Vector3d& point_m,
                 const Eigen::Vector3d& normal, double slack_m) {
  constexpr int kMaxSteps = 40;
  double radius_m = 0.5 * solid.size_m;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::Vector3d centre_m = point_m - radius_m * normal;
    const Eigen::Vector3d nearest_m = solid.distance.closest(centre_m).point_m;
    if ((nearest_m - centre_m).norm() >= radius_m - slack_m) break;
    // The ball that touches at point_m and passes through nearest_m.
    const Eigen::Vector3d chord_m = point_m - nearest_m;
    const double height_m = chord_m.dot(normal);
    if (height_m <= 0.0) break;
    const double shrunk_m = 0.5 * chord_m.squaredNorm() / height_m;
    if (shrunk_m >= radius_m) break;
    radius_m = shrunk_m;
  }
  const Eigen::Vector3d centre_m = point_m - radius_m * normal;
  return {centre_m, -solid.distance.signed_distance_m(centre_m)};
}

std::vector<Ball> medial_balls(const MeshSolid& solid, const SurfaceSamples& samples,
                               double slack_m, double spacing_m, std::size_t most) {
  std::vector<Ball> balls;
  for (std::size_t i = 0; i < samples.points_m.size(); ++i) {
    const Ball ball = medial_ball(solid, samples.points_m[i], samples.normals[i], slack_m);
    if (ball.radius_m > 0.0) balls.push_back(ball);
  }
  std::stable_sort(balls.begin(), balls.end(),
                   [](const Ball& a, const Ball& b) { return a.radius_m > b.radius_m; });
  std::vector<Ball> kept = one_a_cell(balls, spacing_m);
  // Balls on either side of a border of cells stay apart however large these are.
  for (double cell_m = 1.2 * spacing_m; kept.size() > most && cell_m < solid.size_m; cell_m *= 1.2)
    kept = one_a_cell(kept, cell_m);
  return kept;
}

}  // namespace stillgrid::spheres
