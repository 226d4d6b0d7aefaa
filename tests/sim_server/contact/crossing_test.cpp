#include "sim_server/contact/crossing.hpp"

#include <catch2/catch.hpp>
#include <random>

namespace stillgrid::contact::crossing_test {
namespace {

constexpr double kRadiusA_m = 0.01, kRadiusB_m = 0.005, kContactDistance_m = 0.015;

double depth_at(const RelativePath& path, double share) {
  return kContactDistance_m - (path.from_m + share * (path.to_m - path.from_m)).norm();
}

double share_of(const RelativePath& path) {
  return share_before_crossing(path, kRadiusA_m, kRadiusB_m);
}

TEST_CASE("A path that passes at its ends alone is whole: what a step's end shows is not missed",
          "[crossing]") {
  CHECK(share_of({{0.1, 0, 0}, {0.2, 0, 0}}) == 1.0);              // away
  CHECK(share_of({{0.1, 0, 0}, {0.02, 0, 0}}) == 1.0);             // towards
  CHECK(share_of({{0.1, 0, 0}, {0.001, 0, 0}}) == 1.0);            // into, and no farther
  CHECK(share_of({{0.1, 0.016, 0}, {-0.1, 0.016, 0}}) == 1.0);     // past
  CHECK(share_of({{0.0149, 0, 0}, {0.00745, 0.0129, 0}}) == 1.0);  // round, in touch
  CHECK(share_of({{0.0, 0, 0}, {0.1, 0, 0}}) == 1.0);              // out of the middle
}

TEST_CASE("A central crossing stops half of the smaller radius deep", "[crossing]") {
  const RelativePath path{{0.1, 0, 0}, {GENERATE(-0.1, -0.005, -100.0), 0, 0}};
  CHECK(depth_at(path, share_of(path)) == Approx(0.5 * kRadiusB_m));
}

TEST_CASE("However two spheres cross, the part that is left leads to where they overlap",
          "[crossing]") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(-1.0, 1.0), length(0.01, 3.0);
  int crossings = 0, grazes = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d nearest_m =
        0.02 * Eigen::Vector3d(place(random), place(random), place(random));
    const Eigen::Vector3d any(place(random), place(random), place(random));
    const Eigen::Vector3d along = nearest_m.cross(any).normalized();
    const RelativePath path{nearest_m - length(random) * along, nearest_m + length(random) * along};
    const double deepest_m = kContactDistance_m - nearest_m.norm();
    const double share = share_of(path);
    if (depth_at(path, 0.0) > 0.0 || depth_at(path, 1.0) > 0.0) continue;
    if (deepest_m < 0.01 * kRadiusB_m) {
      CHECK(share == 1.0);
      ++grazes;
      continue;
    }
    ++crossings;
    CHECK(depth_at(path, share) > 0.0);
    CHECK(depth_at(path, share) <= 0.5 * kRadiusB_m + 1e-12);
    CHECK(share > 0.0);
  }
  CHECK(crossings > 1000);
  CHECK(grazes > 1000);
}

TEST_CASE("A contact is not pressed to its far side in one step", "[crossing]") {
  const RelativePath through{{0.014, 0, 0}, {-0.014, 0.001, 0}};  // overlaps at both ends
  const double share = share_of(through);
  CHECK(share < 1.0);
  CHECK(depth_at(through, share) == Approx(0.001 + 0.5 * kRadiusB_m));
}

TEST_CASE("The stretch that is left of a shortened path is not shortened again", "[crossing]") {
  const double aside_m = GENERATE(0.0, 0.005, 0.0148);
  RelativePath path{{0.1, aside_m, 0}, {-0.2, aside_m, 0}};
  const double share = share_of(path);
  REQUIRE(share < 1.0);
  path.to_m = path.from_m + share * (path.to_m - path.from_m);
  CHECK(share_of(path) == 1.0);
}

TEST_CASE("A way that turns is judged by its corners, in every part that is left of it",
          "[crossing]") {
  // There and back: neither end tells that the middle was deep, and their chord is of no length.
  std::mt19937 random(13);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  int stopped = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d turn_m = 0.02 * Eigen::Vector3d(place(random), place(random), 0.0);
    std::vector<Eigen::Vector3d> corners_m;
    for (int k = 0; k <= 8; ++k)
      corners_m.push_back(turn_m + Eigen::Vector3d(0.04 * std::abs(k - 4) / 4.0, 0.002 * k, 0));
    const auto at = [&](double share) {
      const double place_on = 8.0 * share;
      const auto k = std::min<std::size_t>(7, static_cast<std::size_t>(place_on));
      const double rest = place_on - static_cast<double>(k);
      return Eigen::Vector3d((1.0 - rest) * corners_m[k] + rest * corners_m[k + 1]);
    };
    const double share = share_before_crossing(corners_m, kRadiusA_m, kRadiusB_m);
    double deepest_before_m = -1.0, deepest_m = -1.0;
    for (int k = 0; k <= 4000; ++k) {
      const double depth_m = kContactDistance_m - at(k / 4000.0).norm();
      deepest_m = std::max(deepest_m, depth_m);
      if (k / 4000.0 <= share) deepest_before_m = std::max(deepest_before_m, depth_m);
    }
    const double start_m = std::max(0.0, kContactDistance_m - at(0.0).norm());
    if (share == 1.0) {
      const bool is_seen = start_m > 0.0 || at(1.0).norm() < kContactDistance_m;
      CHECK((deepest_m <= 0.011 * kRadiusB_m ||
             (is_seen && deepest_m <= start_m + 0.501 * kRadiusB_m) ||
             deepest_m <= kContactDistance_m - at(1.0).norm() + 1e-9));
      continue;
    }
    ++stopped;
    CHECK(kContactDistance_m - at(share).norm() > 0.0);
    CHECK(deepest_before_m <= start_m + 0.501 * kRadiusB_m);
  }
  CHECK(stopped > 200);
}

TEST_CASE("Of several contacts the first crossing counts; planes and numbers that are none do not",
          "[crossing]") {
  Contact still, pair, plane;
  still.a = 0;
  still.radius_a_m = pair.radius_a_m = plane.radius_a_m = kRadiusA_m;
  still.radius_b_m = pair.radius_b_m = kRadiusB_m;
  still.position_b_m = {0.5, 0, 0};
  still.start_b_m = {0.5, 0.2, 0};  // a tool on its way
  pair.a = 0;
  pair.b = 1;
  plane.is_plane = true;
  const std::vector<bodies::SphereMotion> start{{{0, 0, 0}, {0, 0, 0}}, {{0.3, 0, 0}, {0, 0, 0}}};
  const std::vector<bodies::SphereMotion> end{{{0.9, 0.1, 0}, {0, 0, 0}}, {{0.3, 0, 0}, {0, 0, 0}}};
  const auto relative = [&](const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m) {
    return RelativePath{start[0].position_m - from_m, end[0].position_m - to_m};
  };
  const double by_static = share_of(relative(still.start_b_m, still.position_b_m));
  const double by_pair = share_of(relative(start[1].position_m, end[1].position_m));
  CHECK(by_static == 1.0);  // it left the way in time

  CHECK(share_before_crossings(std::vector{plane, still}, {start, end}) == 1.0);
  CHECK(share_before_crossings(std::vector{pair, plane, still}, {start, end}) == by_pair);
  still.start_b_m = still.position_b_m;
  const std::vector<bodies::SphereMotion> level{{{0.9, 0, 0}, {0, 0, 0}}, {{0.3, 0, 0}, {0, 0, 0}}};
  const double first = share_before_crossings(std::vector{still, pair}, {start, level});
  CHECK(first == Approx((0.3 - kContactDistance_m + 0.5 * kRadiusB_m) / 0.9));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(share_of({{nan, 0, 0}, {0, 0, 0}}) == 1.0);
}

}  // namespace
}  // namespace stillgrid::contact::crossing_test
