#include "sim_server/bodies/soft_lattice.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <set>

#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::bodies::soft_lattice_test {
namespace {

/// Balls in a row from one point to another, ends included.
void add_bar(std::vector<spheres::Ball>& balls, const Eigen::Vector3d& from_m,
             const Eigen::Vector3d& to_m, double radius_m) {
  const int count = static_cast<int>((to_m - from_m).norm() / radius_m) + 1;
  for (int i = 0; i <= count; ++i)
    balls.push_back({from_m + double(i) / count * (to_m - from_m), radius_m});
}

/// Two arms 60 mm long, 20 mm thick and 40 mm from axis to axis, joined at one end.
std::vector<spheres::Ball> c_shape() {
  std::vector<spheres::Ball> balls;
  add_bar(balls, {0, 0, 0}, {0, 0, 0.04}, 0.01);
  add_bar(balls, {0, 0, 0}, {0.06, 0, 0}, 0.01);
  add_bar(balls, {0, 0, 0.04}, {0.06, 0, 0.04}, 0.01);
  return balls;
}

Eigen::Vector3d bound_m(const SoftLattice& lattice, const LatticePoint& point) {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 4; ++i)
    sum_m += point.weights[i] * lattice.nodes_m[static_cast<std::size_t>(point.nodes[i])];
  return sum_m;
}

bool has_node_near(const SoftLattice& lattice, const Eigen::Vector3d& point_m, double distance_m) {
  return std::any_of(lattice.nodes_m.begin(), lattice.nodes_m.end(),
                     [&](const auto& node) { return (node - point_m).norm() < distance_m; });
}

TEST_CASE("A block's nodes fill it evenly, x fastest, corners at corners", "[soft_lattice]") {
  const SoftLattice lattice = block_lattice({0.2, 0.3, 0.4}, {3, 2, 5});

  REQUIRE(lattice.nodes_m.size() == 30);
  CHECK(lattice.nodes_m[0].isApprox(Eigen::Vector3d(-0.1, -0.15, -0.2)));
  CHECK(lattice.nodes_m[1].isApprox(Eigen::Vector3d(0.0, -0.15, -0.2)));
  CHECK(lattice.nodes_m[3].isApprox(Eigen::Vector3d(-0.1, 0.15, -0.2)));
  CHECK(lattice.nodes_m[6].isApprox(Eigen::Vector3d(-0.1, -0.15, -0.1)));
  CHECK(lattice.nodes_m[29].isApprox(Eigen::Vector3d(0.1, 0.15, 0.2)));
}

TEST_CASE("A block has each of its springs once: edges, diagonals, two edges in a row",
          "[soft_lattice]") {
  const Eigen::Vector3i n =
      GENERATE(Eigen::Vector3i(2, 2, 2), Eigen::Vector3i(5, 2, 3), Eigen::Vector3i(4, 6, 5));
  const SoftLattice lattice = block_lattice({0.1, 0.1, 0.1}, n);
  const auto springs = lattice_springs(lattice);
  const auto count = [&](LatticeLink link) {
    return std::count_if(springs.begin(), springs.end(),
                         [link](const LatticeSpring& spring) { return spring.link == link; });
  };
  const int x = n.x(), y = n.y(), z = n.z();

  CHECK(count(LatticeLink::kStructural) == (x - 1) * y * z + x * (y - 1) * z + x * y * (z - 1));
  CHECK(count(LatticeLink::kShear) ==
        2 * ((x - 1) * (y - 1) * z + (x - 1) * y * (z - 1) + x * (y - 1) * (z - 1)) +
            4 * (x - 1) * (y - 1) * (z - 1));
  CHECK(count(LatticeLink::kBend) == (x - 2) * y * z + x * (y - 2) * z + x * y * (z - 2));
  std::set<std::pair<int, int>> pairs;
  for (const LatticeSpring& spring : springs) {
    CHECK(spring.a < spring.b);
    CHECK(pairs.insert({spring.a, spring.b}).second);
  }
}

TEST_CASE("An affine motion of the nodes carries every point of the solid along exactly",
          "[soft_lattice]") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  const Eigen::Vector3d size_m(0.2, 0.3, 0.4);
  SoftLattice lattice = block_lattice(size_m, {4, 3, 6});
  SoftLattice moved = lattice;
  Eigen::Matrix3d stretch;
  stretch << 1.3, 0.4, -0.2, 0.1, 0.7, 0.3, -0.5, 0.2, 1.1;
  const Eigen::Vector3d shift_m(0.1, -2.0, 0.4);
  for (Eigen::Vector3d& node : moved.nodes_m) node = stretch * node + shift_m;

  for (int i = 0; i < 1000; ++i) {
    Eigen::Vector3d point_m =
        0.5 * size_m.cwiseProduct(Eigen::Vector3d(place(random), place(random), place(random)));
    if (i % 10 == 0) point_m = lattice.nodes_m[static_cast<std::size_t>(i / 10) % 72];
    const LatticePoint bound = bind_to_lattice(lattice, point_m);
    CHECK((bound_m(moved, bound) - (stretch * point_m + shift_m)).norm() < 1e-14);
    for (const double weight : bound.weights) CHECK(weight >= -1e-12);
  }
}

TEST_CASE("A lattice is there where the balls are, and not in the gap between two arms",
          "[soft_lattice]") {
  const std::vector<spheres::Ball> balls = c_shape();
  const double spacing_m = GENERATE(0.008, 0.01, 0.02);
  const SoftLattice lattice = lattice_round(balls, spacing_m);

  CHECK(place_count(balls, spacing_m) == static_cast<double>(lattice.node_at.size()));
  for (const spheres::Ball& ball : balls) {
    CHECK((bound_m(lattice, bind_to_lattice(lattice, ball.centre_m)) - ball.centre_m).norm() <
          1e-15);
    for (const double sign : {-1.0, 1.0})  // the surface too, but for the least reach
      CHECK(has_node_near(lattice,
                          ball.centre_m + sign * 0.8 * ball.radius_m * Eigen::Vector3d::UnitY(),
                          1.74 * spacing_m));
  }
  CHECK_FALSE(has_node_near(lattice, {0.045, 0, 0.02}, 0.004));
  for (const LatticeSpring& spring : lattice_springs(lattice)) {
    const auto at = [&](int node) { return lattice.nodes_m[static_cast<std::size_t>(node)]; };
    const double longest = spring.link == LatticeLink::kBend ? 2.0 : std::sqrt(3.0);
    CHECK((at(spring.a) - at(spring.b)).norm() < 1.0001 * longest * spacing_m);
  }
}

TEST_CASE("A single small ball gets one cell", "[soft_lattice]") {
  const SoftLattice lattice = lattice_round(std::vector<spheres::Ball>{{{1, 2, 3}, 0.001}}, 0.05);

  CHECK(lattice.nodes_m.size() == 8);
  const LatticePoint middle = bind_to_lattice(lattice, {1, 2, 3});
  CHECK((bound_m(lattice, middle) - Eigen::Vector3d(1, 2, 3)).norm() < 1e-15);
}

}  // namespace
}  // namespace stillgrid::bodies::soft_lattice_test
