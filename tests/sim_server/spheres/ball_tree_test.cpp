#include "sim_server/spheres/ball_tree.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <random>

namespace stillgrid::spheres::ball_tree_test {
namespace {

TEST_CASE("A tree of balls finds what asking each of them finds", "[ball_tree]") {
  std::mt19937 random(5);
  std::normal_distribution<double> place;
  std::exponential_distribution<double> size(4.0);
  for (const int count : {1, 2, 9, 500}) {
    std::vector<Ball> balls;
    for (int i = 0; i < count; ++i)
      balls.push_back({{place(random), place(random), 0.1 * place(random)}, size(random)});
    const BallTree tree(balls);
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector3d point_m(place(random), place(random), place(random));
      const double search_radius_m = size(random) - 0.2;
      double least_m = std::numeric_limits<double>::infinity();
      std::vector<std::uint32_t> within;
      for (std::size_t k = 0; k < balls.size(); ++k) {
        const double gap_m = (point_m - balls[k].centre_m).norm() - balls[k].radius_m;
        least_m = std::min(least_m, gap_m);
        if (gap_m <= search_radius_m) within.push_back(static_cast<std::uint32_t>(k));
      }
      CHECK(tree.least_gap_m(point_m) == least_m);
      CHECK(tree.balls_within(point_m, search_radius_m) == within);
    }
  }
}

}  // namespace
}  // namespace stillgrid::spheres::ball_tree_test
