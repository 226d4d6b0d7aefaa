#include "tests/sim_server/every_target.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

#include "shared/collision/grid_query.hpp"
#include "tests/sim_server/contact/sphere_clouds.hpp"
#include "tests/sim_server/unkind_heap.hpp"

namespace stillgrid::contact::every_target_test {
namespace {

constexpr std::size_t kOffsets_B[] = {0, 16, 32, 48};

/// Numbers of spheres and pairs about the lanes of every vector, and many.
constexpr std::size_t kCounts[] = {2, 3, 4, 5, 7, 8, 9, 15, 16, 17, 31, 33, 500};

TEST_CASE("Overlapping pairs are those of plain arithmetic, in order, on every instruction set",
          "[every_target]") {
  for (const std::size_t offset_B : kOffsets_B)
    for (const std::size_t count : kCounts) {
      const sim_server::UnkindHeap heap(offset_B);
      const DriftingCloud cloud(Cloud::kEqual, Drift::kNone, 24, count);
      const std::vector<collision::SweptBound> balls(cloud.balls().begin(), cloud.balls().end());
      std::mt19937 random(static_cast<unsigned>(count));
      std::uniform_int_distribution<std::uint32_t> any(0, 22);
      std::vector<SpherePair> pairs, expected;
      while (pairs.size() < count) {
        const std::uint32_t a = any(random);
        pairs.push_back({a, a + 1});
      }
      for (const SpherePair& pair : pairs) {
        const auto& [p, r] = balls[pair.a];
        const auto& [q, s] = balls[pair.b];
        const float x = p[0] - q[0], y = p[1] - q[1], z = p[2] - q[2];
        if (x * x + y * y + z * z < (r + s) * (r + s)) expected.push_back(pair);
      }
      sim_server::on_every_target([&] {
        std::vector<SpherePair> found(pairs.size());
        found.resize(overlapping_pairs(pairs, balls, found));
        CAPTURE(offset_B, count);
        CHECK(found == expected);
      });
    }
}

TEST_CASE("Balls that left their swept bounds are found on every instruction set",
          "[every_target]") {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> move(0.0F, 0.0013F);
  for (const std::size_t offset_B : kOffsets_B)
    for (const std::size_t count : kCounts) {
      const sim_server::UnkindHeap heap(offset_B);
      const DriftingCloud cloud(Cloud::kTwoDecades, Drift::kNone, count, count);
      std::vector<collision::SweptBound> balls(cloud.balls().begin(), cloud.balls().end()),
          swept_bounds = balls;
      for (collision::SweptBound& swept_bound : swept_bounds)
        swept_bound.bounding_radius_m += 0.001F;
      for (collision::SweptBound& ball : balls) ball.centre_m[0] += move(random);
      balls[count / 2].centre_m[1] = std::numeric_limits<float>::quiet_NaN();
      std::vector<std::uint32_t> expected;
      for (std::uint32_t i = 0; i < count; ++i)
        if (!holds(swept_bounds[i], balls[i])) expected.push_back(i);
      CAPTURE(offset_B, count);
      sim_server::on_every_target([&] {
        std::vector<std::uint32_t> escaped(expected.size()), few(expected.size() - 1);
        CHECK(find_escaped(balls, swept_bounds, escaped) == expected.size());
        CHECK(escaped == expected);
        CHECK(find_escaped(balls, swept_bounds, few) > few.size());
      });
    }
}

TEST_CASE("Swept bounds that meet are found in one order on every instruction set",
          "[every_target]") {
  const auto kind =
      GENERATE(Cloud::kEqual, Cloud::kTwoDecades, Cloud::kSheet, Cloud::kCoincident, Cloud::kWide);
  // The second is wide enough that only neighbouring cells are searched.
  const float voxel_ratio = GENERATE(1.0F, 1.3F);
  for (const std::size_t offset_B : kOffsets_B)
    for (const std::size_t count : kCounts) {
      const sim_server::UnkindHeap heap(offset_B);
      const DriftingCloud cloud(kind, Drift::kNone, count, count);
      const std::span<const collision::SweptBound> balls = cloud.balls();
      collision::VoxelGrid grid(0, count);
      grid.enter(balls, voxel_ratio);
      std::size_t expected = 0;
      for (std::size_t b = 0; b < count; ++b)
        for (std::size_t a = 0; a < b; ++a)
          expected += collision::meet(balls[a], balls[b]) ? 1U : 0U;
      std::vector<std::vector<SpherePair>> found;
      sim_server::on_every_target([&] {
        SortedBounds sorted(count);
        std::vector<SpherePair> pairs;
        pairs.resize(search_pairs(grid.view(), {}, count * count, sorted, pairs));
        found.push_back(pairs);
      });
      CAPTURE(cloud.description(), offset_B, voxel_ratio);
      CHECK(found[0].size() == expected);
      for (const SpherePair& pair : found[0]) CHECK(collision::meet(balls[pair.a], balls[pair.b]));
      for (const auto& pairs : found) CHECK(pairs == found[0]);
    }
}

TEST_CASE("A search gives up soon after more pairs than asked for, on every instruction set",
          "[every_target]") {
  constexpr std::size_t kCount = 3000, kMaxPairs = 5000;
  const DriftingCloud cloud(Cloud::kCoincident, Drift::kNone, kCount, 3);
  collision::VoxelGrid grid(0, kCount);
  grid.enter(cloud.balls(), GENERATE(1.0F, 1.3F));
  sim_server::on_every_target([&] {
    SortedBounds sorted(kCount);
    std::vector<SpherePair> pairs;
    const std::size_t all = search_pairs(grid.view(), {}, kCount * kCount, sorted, pairs);
    REQUIRE(all > 4 * kMaxPairs);
    std::vector<SpherePair> few;
    CHECK(search_pairs(grid.view(), {}, kMaxPairs, sorted, few) > kMaxPairs);
    CHECK(few.size() < all);
    CHECK(std::equal(few.begin(), few.begin() + kMaxPairs, pairs.begin()));
    CHECK(search_pairs(grid.view(), {}, all, sorted, few) == all);
  });
}

}  // namespace
}  // namespace stillgrid::contact::every_target_test
