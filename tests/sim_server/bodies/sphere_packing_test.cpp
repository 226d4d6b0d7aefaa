#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <random>
#include <vector>

#include "sim_server/bodies/kinds/body_in_world.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::bodies::sphere_packing_test {
namespace {

BodyDescription tilted_sheet() {
  BodyDescription body = sim_server::sheet({4, 3}, 0.02, 0.002, 500.0);
  body.position_m = {0.1, -0.2, 0.3};
  body.orientation = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized());
  return body;
}

BodyDescription tilted_block() {
  BodyDescription body = sim_server::soft_block({3, 4, 5}, 0.01, 0.001, 10.0, {0.01, 0.002});
  body.position_m = {0.1, -0.2, 0.3};
  body.orientation = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized());
  return body;
}

/// Where the nodes of a body's own world put a sphere at rest.
Eigen::Vector3d woven_m(const SphereBinding& sphere, const World& world) {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < static_cast<std::size_t>(sphere.node_count); ++i)
    position_m +=
        sphere.weights[i] * world.nodes[static_cast<std::size_t>(sphere.nodes[i])].position_m;
  return position_m;
}

TEST_CASE("The number of spheres is known before they are made", "[sphere_packing]") {
  BodyDescription body =
      GENERATE(tilted_sheet(), sim_server::thread(7, {0, 0, 1}, {0.3, 0.1, 0.5}, 0.01, 100.0),
               sim_server::box({0, 0, 0}, {0.03, 0.05, 0.02}, 0.02, {0.01, 0.005}),
               sim_server::soft_block({3, 4, 5}, 0.01, 0.001, 10.0, {0.01, 0.002}),
               sim_server::rigid_mesh({{{0, 0, 0}, 0.1}, {{0, 0, 1}, 0.2}}, {1, 1, 1}, 1.0));
  const double spacing_m = GENERATE(0.0, 0.004, 0.013);
  if (balls_of(body).empty()) sim_server::packing(body).spacing_m = spacing_m;
  CHECK(counts_of(body).spheres == static_cast<double>(pack_spheres(body).size()));
}

TEST_CASE("A box as thin as a hair asks for more spheres than memory, and says so at once",
          "[sphere_packing]") {
  BodyDescription body = sim_server::box({0, 0, 0}, {1.0, 1.0, 1e-5}, 0.02, {0.0, 0.0});
  CHECK(counts_of(body).spheres > 1e10);
}

TEST_CASE("A body of nodes has its spheres where its nodes carry them", "[sphere_packing]") {
  BodyDescription body = GENERATE(tilted_sheet(), tilted_block(),
                                  sim_server::thread(7, {0, 0, 1}, {0.3, 0.1, 0.5}, 0.01, 100.0));
  sim_server::packing(body).spacing_m = GENERATE(0.0, 0.007, 0.013, 0.05, 10.0);
  const World world = scene::build_world(sim_server::scene_of({body}));

  for (const SphereBinding& sphere : pack_spheres(body)) {
    REQUIRE(sphere.node_count >= 1);
    CHECK(std::accumulate(sphere.weights.begin(), sphere.weights.end(), 0.0) == Approx(1.0));
    CHECK((woven_m(sphere, world) - sphere.rest_position_m).norm() < 1e-15);
    for (std::size_t i = 0; i < static_cast<std::size_t>(sphere.node_count); ++i) {
      CHECK(sphere.weights[i] > 0.0);
      CHECK(sphere.nodes[i] < static_cast<int>(world.nodes.size()));
    }
  }
}

TEST_CASE("Spheres stand evenly from one end of a thread to the other", "[sphere_packing]") {
  BodyDescription body = sim_server::thread(5, {0, 0, 0}, {0.09, 0, 0}, 0.01, 100.0);
  sim_server::packing(body) = {0.01, 0.003};

  const auto spheres = pack_spheres(body);

  REQUIRE(spheres.size() == 10);  // ceil(0.09 / 0.01) + 1
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    CHECK(spheres[i].rest_position_m.x() == Approx(0.01 * static_cast<double>(i)).margin(1e-15));
    CHECK(spheres[i].radius_m == 0.003);
  }
}

TEST_CASE("A sheet is covered in rows up to its edges", "[sphere_packing]") {
  BodyDescription body = sim_server::sheet({8, 8}, 0.02, 0.002, 500.0);
  sim_server::packing(body) = {0.01, 0.0065};

  const auto spheres = pack_spheres(body);

  REQUIRE(spheres.size() == 225);
  CHECK((spheres.front().rest_position_m - Eigen::Vector3d(-0.07, -0.07, 0)).norm() < 1e-15);
  CHECK((spheres.back().rest_position_m - Eigen::Vector3d(0.07, 0.07, 0)).norm() < 1e-15);
}

TEST_CASE("Without a packing each node has a sphere as large as the spacing", "[sphere_packing]") {
  BodyDescription body = sim_server::thread(6, {0, 0, 0}, {0.1, 0, 0}, 0.01, 100.0);
  sim_server::packing(body) = {};

  CHECK(pack_spheres(body).size() == 6);
  CHECK(pack_spheres(body)[0].radius_m == Approx(0.02));
  CHECK(pack_spheres(tilted_sheet()).size() == 12);
  CHECK(pack_spheres(tilted_sheet())[0].radius_m == Approx(0.02));
}

/// Returns the largest distance between neighbours along an axis, of spheres on a level lattice.
double widest_gap_m(const std::vector<SphereBinding>& spheres, int axis) {
  std::vector<double> places_m;
  for (const SphereBinding& sphere : spheres) places_m.push_back(sphere.rest_position_m[axis]);
  std::sort(places_m.begin(), places_m.end());
  double gap_m = 0.0;
  for (std::size_t i = 1; i < places_m.size(); ++i)
    gap_m = std::max(gap_m, places_m[i] - places_m[i - 1]);
  return gap_m;
}

TEST_CASE("A cover that is not given whole has its spheres at most a radius apart",
          "[sphere_packing]") {
  std::mt19937_64 random(GENERATE(range(1U, 41U)));
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  const Eigen::Vector3d size_m(between(0.01, 0.2), between(0.01, 0.2), between(0.01, 0.2));
  const double part = between(0.05, 0.5) * size_m.minCoeff();
  const SpherePacking spheres =
      GENERATE_COPY(SpherePacking{}, SpherePacking{0.0, part}, SpherePacking{part, 0.0});
  const auto nodes = [&] { return 2 + static_cast<int>(between(0.0, 8.0)); };
  BodyDescription sheet = sim_server::sheet({nodes(), nodes()}, between(0.01, 0.05), 0.01, 10.0);
  BodyDescription thread = sim_server::thread(nodes(), {0, 0, 0}, {size_m.x(), 0, 0}, 0.01, 10.0);
  sim_server::packing(sheet) = sim_server::packing(thread) = spheres;

  for (const BodyDescription& body :
       {sim_server::box({0, 0, 0}, size_m, 0.1, spheres), sheet, thread}) {
    const std::vector<SphereBinding> cover = pack_spheres(body);
    for (int axis = 0; axis < 3; ++axis)
      CHECK(widest_gap_m(cover, axis) <= cover[0].radius_m * (1.0 + 1e-5));
  }
}

TEST_CASE("A box has two spheres at least along its shortest side", "[sphere_packing]") {
  const auto count = [](const Eigen::Vector3d& size_m) {
    return pack_spheres(sim_server::box({0, 0, 0}, size_m, 1.0, {})).size();
  };
  CHECK(count({0.1, 0.1, 0.1}) == 5 * 5 * 5);
  CHECK(count({0.1, 0.1, 0.01}) == 29 * 29 * 2);
  CHECK(count({0.1, 0.01, 0.01}) == 29 * 2 * 2);
}

TEST_CASE("A box is filled: its outer spheres touch the faces and none sticks out",
          "[sphere_packing]") {
  const Eigen::Vector3d size_m(0.03, 0.05, 0.02);
  const SpherePacking spheres =
      GENERATE(SpherePacking{0.01, 0.005}, SpherePacking{0.004, 0.007}, SpherePacking{});
  BodyDescription body = sim_server::box({0.1, 0.2, 0.3}, size_m, 0.02, spheres);
  body.orientation = Eigen::AngleAxisd(1.1, Eigen::Vector3d(0, 1, 1).normalized());
  Eigen::Vector3d low = size_m, high = -size_m;

  for (const SphereBinding& sphere : pack_spheres(body)) {
    low = low.cwiseMin((sphere.local_m.array() - sphere.radius_m).matrix());
    high = high.cwiseMax((sphere.local_m.array() + sphere.radius_m).matrix());
    CHECK((sphere.rest_position_m - body.position_m - body.orientation * sphere.local_m).norm() <
          1e-15);
  }

  CHECK((low + 0.5 * size_m).norm() < 1e-15);
  CHECK((high - 0.5 * size_m).norm() < 1e-15);
}

TEST_CASE("A box has ceil((side - 2 radius) / spacing) + 1 spheres a side", "[sphere_packing]") {
  CHECK(pack_spheres(sim_server::box({0, 0, 0}, {0.03, 0.03, 0.02}, 1.0, {0.01, 0.005})).size() ==
        3 * 3 * 2);
}

TEST_CASE("A side with one sphere has it in the middle", "[sphere_packing]") {
  const auto spheres =
      pack_spheres(sim_server::box({0, 0, 0}, {0.04, 0.01, 0.01}, 1.0, {0.01, 0.005}));

  for (const SphereBinding& sphere : spheres) {
    CHECK(sphere.local_m.y() == 0.0);
    CHECK(sphere.local_m.z() == 0.0);
  }
}

TEST_CASE("A sphere is its own cover, and a plane has none", "[sphere_packing]") {
  const auto spheres = pack_spheres(sim_server::sphere({1, 2, 3}, 0.25, 1.0));

  REQUIRE(spheres.size() == 1);
  CHECK(spheres[0].rest_position_m == Eigen::Vector3d(1, 2, 3));
  CHECK(spheres[0].radius_m == 0.25);
  CHECK(spheres[0].local_m.isZero(0.0));
  CHECK(pack_spheres(sim_server::floor_at(0.0)).empty());
}

}  // namespace
}  // namespace stillgrid::bodies::sphere_packing_test
