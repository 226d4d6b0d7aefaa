#include "shared/dynamics/near_pairs.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <set>
#include <utility>

#include "shared/dynamics/row_packer.hpp"
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

TEST_CASE("All pairs of balls that overlap are found, once, however far some are out",
          "[dynamics]") {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const std::vector<Vector4> balls =
        drawn_balls(seed, static_cast<int>(seed * seed % 400), seed % 3 == 0);
    sim_server::on_every_target([&] {
      NearPairs near;
      near.find(balls);
      std::set<std::pair<std::int32_t, std::int32_t>> found;
      for (const NearPair& pair : near.pairs()) {
        const auto a = near.order()[static_cast<std::size_t>(pair.first)];
        const auto b = near.order()[static_cast<std::size_t>(pair.second)];
        REQUIRE(found.insert(std::minmax(a, b)).second);
      }
      for (std::size_t i = 0; i < balls.size(); ++i)
        for (std::size_t j = i + 1; j < balls.size(); ++j) {
          const double distance = (balls[i] - balls[j]).vector().norm();
          const double overlap = balls[i].w + balls[j].w - distance;
          const bool is_found =
              found.contains({static_cast<std::int32_t>(i), static_cast<std::int32_t>(j)});
          if (overlap > 0.0) REQUIRE(is_found);
          if (overlap < -1e-3 && !(seed % 3 == 0)) REQUIRE(!is_found);
        }
    });
  }
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

}  // namespace
}  // namespace stillgrid::dynamics::near_pairs_test
