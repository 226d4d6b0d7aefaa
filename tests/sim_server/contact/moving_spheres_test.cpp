#include "sim_server/contact/moving_spheres.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "shared/collision/grid_query.hpp"
#include "tests/haptic_server/devices/allocation_counter.hpp"
#include "tests/sanitizer_cut.hpp"
#include "tests/sim_server/contact/sphere_clouds.hpp"
#include "tests/sim_server/every_target.hpp"

namespace stillgrid::contact::moving_spheres_test {
namespace {

constexpr float kAutomatic = 0.0F;
constexpr unsigned kRounds = 64 / tests::kCut;

void check_pairs(MovingSpheres& spheres, const DriftingCloud& cloud) {
  const auto found = ascending(spheres.find(cloud.balls()));
  const auto expected = tested_pairs(cloud.balls());
  if (found != expected)
    FAIL_CHECK(cloud.description()
               << ": " << found.size() << " pairs, expected " << expected.size());
}

TEST_CASE("The pairs found are those that overlap, each once, in every scene and motion",
          "[moving_spheres]") {
  std::mt19937_64 random(1);
  std::uniform_int_distribution<std::size_t> size(0, 160);
  const float ratios[] = {kAutomatic, 1.0F, 0.4F, 2.5F};
  std::uint64_t seed = 0, pairs = 0;
  for (unsigned round = 0; round < kRounds; ++round)
    for (int cloud = 0; cloud < static_cast<int>(Cloud::kCount); ++cloud)
      for (int drift = 0; drift < static_cast<int>(Drift::kCount); ++drift) {
        DriftingCloud spheres(static_cast<Cloud>(cloud), static_cast<Drift>(drift), size(random),
                              ++seed);
        MovingSpheres moving(spheres.balls().size(), ratios[seed % 4]);
        for (int step = 0; step < 6; ++step, spheres.step()) check_pairs(moving, spheres);
        pairs += moving.listed_pairs();
      }
  CHECK(seed == std::uint64_t{48} * kRounds);
  CHECK(pairs > 100'000 / tests::kCut);
}

TEST_CASE("They are the same, in the same order, on every instruction set", "[moving_spheres]") {
  const auto cloud = GENERATE(Cloud::kEqual, Cloud::kTwoDecades, Cloud::kWide);
  const auto drift = GENERATE(Drift::kSlow, Drift::kFast, Drift::kMixed);
  std::vector<std::vector<SpherePair>> first;
  sim_server::on_every_target([&] {
    DriftingCloud spheres(cloud, drift, 3001, 7);
    MovingSpheres moving(spheres.balls().size(), kAutomatic);
    std::vector<std::vector<SpherePair>> found;
    for (int step = 0; step < 12; ++step, spheres.step()) {
      const auto pairs = moving.find(spheres.balls());
      found.emplace_back(pairs.begin(), pairs.end());
    }
    if (first.empty()) {
      CHECK(ascending(found[0]) == tested_pairs(DriftingCloud(cloud, drift, 3001, 7).balls()));
      first = found;
    }
    CHECK(found == first);
  });
}

TEST_CASE("Two octaves share a level until it is crowded, and all pairs are found in both",
          "[moving_spheres]") {
  constexpr std::size_t kCount = 1000;
  std::mt19937_64 random(12);
  std::uniform_real_distribution<float> place(-1.0F, 1.0F), radius(0.003F, 0.011F);
  MovingSpheres moving(kCount, kAutomatic);
  const auto levels_at = [&](float half_edge_m) {
    std::vector<collision::SweptBound> balls(kCount);
    for (std::size_t i = 0; i < kCount; ++i)
      balls[i] = {{half_edge_m * place(random), half_edge_m * place(random), 0.01F * place(random)},
                  i == 0 ? 0.011F : radius(random)};
    CHECK(ascending(moving.find(balls)) == tested_pairs(balls));
    return moving.grid().view().shape.level_count;
  };
  CHECK(levels_at(0.5F) == 1);
  CHECK(levels_at(0.03F) == 2);
  std::uint32_t least = 2;
  for (int step = 0; step < 80; ++step) least = std::min(least, levels_at(0.5F));
  CHECK(least == 1);  // it is tried again
}

TEST_CASE("A hundred thousand spheres are paired exactly", "[moving_spheres]") {
  const auto cloud = GENERATE(Cloud::kEqual, Cloud::kSheet, Cloud::kTwoDecades);
  DriftingCloud spheres(cloud, Drift::kSlow, cloud == Cloud::kEqual ? 100'000 : 20'000, 3);
  MovingSpheres moving(spheres.balls().size(), kAutomatic);
  for (int step = 0; step < 3; ++step, spheres.step()) check_pairs(moving, spheres);
}

TEST_CASE("A long slow motion is followed exactly, through many lists", "[moving_spheres]") {
  DriftingCloud spheres(Cloud::kEqual, GENERATE(Drift::kSlow, Drift::kMixed, Drift::kTeleport), 400,
                        5);
  MovingSpheres moving(400, kAutomatic);
  for (int step = 0; step < 300; ++step, spheres.step()) check_pairs(moving, spheres);
}

TEST_CASE("What rests or trembles is entered once, what moves slowly seldom", "[moving_spheres]") {
  const auto entered_in_200_steps = [](Drift drift) {
    DriftingCloud spheres(Cloud::kEqual, drift, 2000, 6);
    MovingSpheres moving(2000, kAutomatic);
    for (int step = 0; step < 200; ++step, spheres.step()) (void)moving.find(spheres.balls());
    return moving.entered_count();
  };
  CHECK(entered_in_200_steps(Drift::kNone) == 1);
  CHECK(entered_in_200_steps(Drift::kTrembling) == 1);
  CHECK(entered_in_200_steps(Drift::kSlow) < 40);
  CHECK(entered_in_200_steps(Drift::kFast) > 100);
}

TEST_CASE("Spheres of one group are never paired, all others are, in every scene and motion",
          "[moving_spheres]") {
  for (int cloud = 0; cloud < static_cast<int>(Cloud::kCount); ++cloud)
    for (int drift = 0; drift < static_cast<int>(Drift::kCount); ++drift)
      for (const std::uint32_t group_size : {1U, 7U, 60U, 400U}) {
        DriftingCloud spheres(static_cast<Cloud>(cloud), static_cast<Drift>(drift), 240, 9);
        std::vector<std::uint32_t> groups;
        for (std::uint32_t i = 0; i < 240; ++i)
          groups.push_back(i % 11 == 0 ? kNoGroup : i / group_size);
        MovingSpheres grouped(240, kAutomatic, groups), filtered(240, kAutomatic);
        const PairFilter may_collide = [&](std::uint32_t a, std::uint32_t b) {
          return groups[a] == kNoGroup || groups[a] != groups[b];
        };
        for (int step = 0; step < 6; ++step, spheres.step()) {
          const auto found = grouped.find(spheres.balls());
          const auto expected = filtered.find(spheres.balls(), may_collide);
          // In the same order, so that no sum over contacts comes out otherwise.
          if (!std::equal(found.begin(), found.end(), expected.begin(), expected.end()))
            FAIL_CHECK(spheres.description() << ": groups of " << group_size);
        }
      }
}

TEST_CASE("Pairs that may not collide are never found, the others all", "[moving_spheres]") {
  DriftingCloud spheres(Cloud::kEqual, Drift::kSlow, 500, 8);
  MovingSpheres moving(500, kAutomatic);
  const PairFilter odd = [](std::uint32_t a, std::uint32_t b) { return (a + b) % 2 == 1; };
  for (int step = 0; step < 60; ++step, spheres.step()) {
    auto expected = tested_pairs(spheres.balls());
    std::erase_if(expected, [&](const SpherePair& pair) { return !odd(pair.a, pair.b); });
    CHECK(ascending(moving.find(spheres.balls(), odd)) == expected);
  }
}

TEST_CASE("Few spheres that are entered before the first step obey the filter too",
          "[moving_spheres]") {
  const std::size_t count = GENERATE(2U, 3U, 4U);
  const std::vector<collision::SweptBound> balls(count,
                                                 collision::SweptBound{{0.0F, 0.0F, 0.0F}, 0.01F});
  MovingSpheres moving(count, kAutomatic);
  moving.enter(balls);
  const PairFilter never = [](std::uint32_t, std::uint32_t) { return false; };
  for (int step = 0; step < 5; ++step) CHECK(moving.find(balls, never).empty());

  MovingSpheres unfiltered(count, kAutomatic);
  unfiltered.enter(balls);
  for (int step = 0; step < 5; ++step)
    CHECK(unfiltered.find(balls).size() == count * (count - 1) / 2);
}

TEST_CASE("Nothing is allocated once the lists have their length", "[moving_spheres]") {
  if (!devices::allocation_count()) {
    WARN("skipped: only the address sanitizer counts allocations");
    return;
  }
  DriftingCloud spheres(Cloud::kEqual, GENERATE(Drift::kSlow, Drift::kFast), 3000, 10);
  MovingSpheres moving(3000, kAutomatic);
  std::uint64_t allocated = 0;
  for (int step = 0; step < 200; ++step, spheres.step()) {
    const std::uint64_t before = *devices::allocation_count();
    (void)moving.find(spheres.balls());
    if (step >= 100) allocated += *devices::allocation_count() - before;
  }
  CHECK(allocated == 0);
}

TEST_CASE("A sphere whose place is no number is refused by its number, and does no harm",
          "[moving_spheres]") {
  DriftingCloud spheres(Cloud::kEqual, Drift::kNone, 100, 11);
  MovingSpheres moving(100, kAutomatic);
  const bool entered_before = GENERATE(true, false);
  if (entered_before) (void)moving.find(spheres.balls());
  std::vector<collision::SweptBound> balls(spheres.balls().begin(), spheres.balls().end());
  const float bad =
      GENERATE(std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity());
  (GENERATE(true, false) ? balls[17].centre_m[1] : balls[17].bounding_radius_m) = bad;

  CHECK_THROWS_WITH(moving.find(balls), Catch::Contains("sphere 17 "));
  check_pairs(moving, spheres);
}

}  // namespace
}  // namespace stillgrid::contact::moving_spheres_test
