#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "shared/collision/tool_proxy.hpp"

namespace stillgrid::collision {
namespace {

using Eigen::Vector3d;

/// Half-spaces whose normals differ by up to `spread`, as those of a dense cover or of a corner.
std::vector<HalfSpace> drawn(std::mt19937& random, double spread) {
  std::normal_distribution<double> aside;
  std::uniform_real_distribution<double> gap_m(-1e-4, 1e-3);
  std::vector<HalfSpace> spaces(2 + random() % 30);
  for (HalfSpace& space : spaces) {
    space.normal =
        (Vector3d::UnitZ() + spread * Vector3d(aside(random), aside(random), aside(random)))
            .normalized();
    space.gap_m = gap_m(random);
  }
  return spaces;
}

}  // namespace

TEST_CASE("A proxy ends outside all half-spaces, whatever their order", "[proxy]") {
  constexpr double kRounding_m = 1e-9;
  const double spread = GENERATE(0.0, 0.001, 0.03, 0.3);
  std::mt19937 random(7);
  for (int round = 0; round < 500; ++round) {
    std::vector<HalfSpace> spaces = drawn(random, spread);
    const Vector3d goal_m(0.0, 0.0, -0.003);
    const Vector3d way_m = push_out(goal_m, spaces);
    Vector3d pushed_m = goal_m;
    for (const HalfSpace& space : spaces) {
      pushed_m += space.push_m * space.normal;
      const double gap_m = space.gap_m + space.normal.dot(way_m);
      REQUIRE(space.push_m >= 0.0);
      REQUIRE(space.push_m <= std::max(0.0, space.depth_m) + kRounding_m);
      // It pushes where it touches, and one at its depth may give way.
      if (space.push_m < space.depth_m - kRounding_m) REQUIRE(gap_m > -kRounding_m);
      if (space.push_m > kRounding_m && space.push_m < space.depth_m - kRounding_m)
        REQUIRE(gap_m < kRounding_m);
    }
    REQUIRE((pushed_m - way_m).norm() < kRounding_m);
    std::ranges::shuffle(spaces, random);
    REQUIRE((push_out(goal_m, spaces) - way_m).norm() < 10.0 * kRounding_m);
  }
}

}  // namespace stillgrid::collision
