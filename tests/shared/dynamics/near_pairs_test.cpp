#include "shared/dynamics/near_pairs.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "shared/dynamics/contact_listing.hpp"
#include "shared/dynamics/row_packer.hpp"
#include "tests/shared/dynamics/engine_scenes.hpp"
#include "tests/sim_server/every_target.hpp"

namespace stillgrid::dynamics::near_pairs_test {
namespace {

std::vector<Vector4> drawn_balls(std::uint64_t seed, int count, bool has_outliers) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> place(-0.1, 0.1), radius(0.002, 0.01);
  std::vector<Vector4> balls;
  for (int k = 0; k < count; ++k)
    balls.emplace_back(place(random), place(random), place(random), radius(random));
  if (has_outliers) {
    balls.emplace_back(1e4, 0.0, 0.0, 0.01);
    balls.emplace_back(1e4 + 0.005, 0.0, 0.0, 0.01);
    balls.emplace_back(0.0, -3e3, 2e2, 0.01);
  }
  return balls;
}

TEST_CASE(
    "All pairs of balls that overlap are found, once, however far some are out, but for pairs "
    "that never move",
    "[dynamics]") {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const std::vector<Vector4> balls =
        drawn_balls(seed, static_cast<int>(seed * seed % 400), seed % 3 == 0);
    const std::size_t moving = balls.size() - seed % 4 * balls.size() / 3;
    sim_server::on_every_target([&] {
      NearPairs near;
      near.find(balls, balls.size() - moving);
      std::set<std::pair<std::int32_t, std::int32_t>> found;
      for (const NearPair& pair : near.pairs()) {
        const auto a = near.order()[static_cast<std::size_t>(pair.first)];
        const auto b = near.order()[static_cast<std::size_t>(pair.second)];
        REQUIRE(pair.first < pair.second);
        REQUIRE(found.insert(std::minmax(a, b)).second);
      }
      for (std::size_t i = 0; i < balls.size(); ++i)
        for (std::size_t j = i + 1; j < balls.size(); ++j) {
          const double distance = (balls[i] - balls[j]).vector().norm();
          const double overlap = balls[i].w + balls[j].w - distance;
          const bool is_found =
              found.contains({static_cast<std::int32_t>(i), static_cast<std::int32_t>(j)});
          if (overlap > 0.0) REQUIRE(is_found == (i < moving));
          if (overlap < -1e-3 && !(seed % 3 == 0)) REQUIRE(!is_found);
        }
    });
  }
}

TEST_CASE("Balls near a place are found among those that move and those that never do",
          "[dynamics]") {
  const std::vector<Vector4> balls = drawn_balls(7, 300, false);
  NearPairs near;
  near.find(balls, 200);
  for (const Vector4& ball : balls) {
    std::vector<std::int32_t> places;
    near.append_near(ball, places);
    CHECK(std::ranges::is_sorted(places));
    std::set<std::int32_t> found;
    for (const std::int32_t place : places)
      found.insert(near.order()[static_cast<std::size_t>(place)]);
    for (std::size_t j = 0; j < balls.size(); ++j)
      if ((ball - balls[j]).vector().norm() < ball.w + balls[j].w)
        CHECK(found.contains(static_cast<std::int32_t>(j)));
  }
}

/// A carpet of 40 x 40 driven spheres that never move, and nine balls that touch it.
EngineScene balls_on_carpet(bool is_fixture) {
  EngineScene scene;
  for (int i = 0; i < 9; ++i) scene.add_ball(0.012, {0.18 * (i / 3), 0.18 * (i % 3), 0.0185});
  const int carpet = scene.add_rigid(0.0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), true);
  scene.description.rigid_bodies.back().is_fixture = is_fixture;
  for (int i = 0; i < 1600; ++i)
    scene.add_sphere(carpet, 0.01, 0.01 * Eigen::Vector3d(i / 40, i % 40, 0));
  scene.state.is_here.assign(scene.description.rigid_bodies.size(), 1);
  return scene;
}

/// Pairs of spheres in the listed rows.
std::set<std::pair<std::int32_t, std::int32_t>> listed_pairs(const ContactListing& listing) {
  std::set<std::pair<std::int32_t, std::int32_t>> pairs;
  for (const RowPlace& place : listing.rows().places)
    for (std::size_t lane = 0; lane < kRowLanes; ++lane)
      if (place.stiffness_N_per_m[lane] > 0.0F)
        pairs.insert(std::minmax(listing.order()[static_cast<std::size_t>(place.sphere_a[lane])],
                                 listing.order()[static_cast<std::size_t>(place.sphere_b[lane])]));
  return pairs;
}

TEST_CASE("Spheres that never move are not compared with each other, and the contacts are the same",
          "[dynamics]") {
  const EngineScene fixed = balls_on_carpet(true), driven = balls_on_carpet(false);
  ContactListing of_fixed(fixed.description), of_driven(driven.description);
  of_fixed.list(fixed.state, 1e-3);
  of_driven.list(driven.state, 1e-3);
  CHECK(listed_pairs(of_fixed) == listed_pairs(of_driven));
  CHECK(listed_pairs(of_fixed).size() > 30);
  CHECK(of_fixed.near_pairs() == static_cast<double>(listed_pairs(of_fixed).size()));
  CHECK(of_driven.comparisons() > 20.0 * 1600.0);
  CHECK(of_fixed.comparisons() < 1600.0);
}

TEST_CASE("No row has a mover twice, and every item is in one row", "[dynamics]") {
  std::mt19937_64 random(5);
  std::uniform_int_distribution<std::int32_t> mover(0, 39);
  RowPacker packer;
  for (int repetition = 0; repetition < 20; ++repetition) {
    std::vector<std::array<std::int32_t, 2>> items(static_cast<std::size_t>(50 * repetition));
    packer.start(40);
    for (std::size_t k = 0; k < items.size(); ++k) {
      items[k] = {mover(random), mover(random)};
      packer.add(static_cast<std::int32_t>(k), items[k]);
    }
    packer.finish();
    std::set<std::int32_t> seen;
    for (const RowPacker::Row& row : packer.rows()) {
      std::set<std::int32_t> movers;
      for (const std::int32_t item : row) {
        if (item < 0) continue;
        REQUIRE(seen.insert(item).second);
        for (const std::int32_t m : std::set(items[static_cast<std::size_t>(item)].begin(),
                                             items[static_cast<std::size_t>(item)].end()))
          REQUIRE(movers.insert(m).second);
      }
    }
    CHECK(seen.size() == items.size());
  }
}

TEST_CASE("Parts that are solved side by side have no ball in common", "[dynamics]") {
  std::mt19937_64 random(6);
  for (const std::size_t places : {100UL, 4096UL, 4097UL, 40000UL, 65537UL, 1000000UL}) {
    std::uniform_int_distribution<std::size_t> place(0, places - 1), apart(0, 2000);
    std::map<std::pair<std::uint32_t, std::size_t>, std::uint32_t> part_of_ball;
    std::size_t alone = 0;
    for (int k = 0; k < 20000; ++k) {
      const std::size_t a = place(random), b = std::min(places - 1, a + apart(random));
      const std::uint32_t part = part_of(places, a, b);
      REQUIRE(part < kContactParts);
      if (part == 0) ++alone;
      for (const std::size_t ball : {a, b})
        if (part != 0)
          REQUIRE(part_of_ball.try_emplace({part % 2, ball}, part).first->second == part);
    }
    CHECK(alone == (places <= 4096 ? 20000 : 0));
  }
}

}  // namespace
}  // namespace stillgrid::dynamics::near_pairs_test
