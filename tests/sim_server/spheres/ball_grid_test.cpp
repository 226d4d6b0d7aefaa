#include "sim_server/spheres/ball_grid.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

namespace stillgrid::spheres::ball_grid_test {
namespace {

TEST_CASE("No ball within reach is left out, whatever its size", "[ball_grid]") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place_m(-0.5, 0.5), decade(-3.0, -0.7);
  const auto place = [&] {
    return Eigen::Vector3d(place_m(random), place_m(random), 0.1 * place_m(random));
  };
  for (const std::size_t count : {1U, 2U, 40U, 3000U}) {
    std::vector<Ball> balls;
    for (std::size_t i = 0; i < count; ++i)
      balls.push_back({place(), std::pow(10.0, decade(random))});
    const double search_radius_m = GENERATE(0.0, 0.03);
    const BallGrid grid = make_ball_grid(balls, search_radius_m);

    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3d point_m = 1.5 * place();
      const auto near = balls_near(grid, point_m);
      REQUIRE(std::adjacent_find(near.begin(), near.end(), std::greater_equal<>()) == near.end());
      for (std::uint32_t j = 0; j < balls.size(); ++j)
        if ((point_m - balls[j].centre_m).norm() <= balls[j].radius_m + search_radius_m)
          REQUIRE(std::binary_search(near.begin(), near.end(), j));
    }
  }
}

TEST_CASE("A cell names few balls that do not reach it", "[ball_grid]") {
  std::vector<Ball> balls;
  for (int i = 0; i < 1000; ++i) balls.push_back({{0.01 * i, 0.0, 0.0}, 0.005});
  const BallGrid grid = make_ball_grid(balls, 0.005);
  for (int i = 0; i < 1000; ++i) CHECK(balls_near(grid, {0.01 * i, 0.0, 0.0}).size() <= 8);
}

TEST_CASE("Far away, at no place, or among no balls, there is none", "[ball_grid]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Ball> ball{{Eigen::Vector3d::Zero(), 1.0}};
  const BallGrid grid = make_ball_grid(ball, 0.1);
  CHECK(balls_near(grid, {1e300, 0.0, 0.0}).empty());
  CHECK(balls_near(grid, {0.0, -2.0, 0.0}).empty());
  CHECK(balls_near(grid, {0.0, nan, 0.0}).empty());
  CHECK(balls_near(make_ball_grid({}, 0.1), {0.0, 0.0, 0.0}).empty());
}

}  // namespace
}  // namespace stillgrid::spheres::ball_grid_test
