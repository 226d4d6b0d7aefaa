#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "shared/collision/grid_query.hpp"
#include "tests/shared/collision/random_scene.hpp"

namespace stillgrid::collision::hostile_grid_test {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct Query {
  std::vector<std::uint32_t> visited;
  bool was_truncated = false;
};

Query query(const GridView& view, const SweptBound& probe, std::uint32_t max_visits) {
  Query result;
  result.was_truncated = for_each_candidate(
      view, probe, max_visits, [&](std::uint32_t sphere) { result.visited.push_back(sphere); });
  return result;
}

/// A level that fits its layout in most cases, of any numbers else.
proto::GridLevel random_level(std::mt19937_64& random, std::size_t cell_capacity) {
  proto::GridLevel level{};
  level.voxel_m = random() % 4 ? 0.01F : 1e-30F;
  level.bounding_radius_m = random() % 4 ? 0.01F : 1e30F;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    level.cells[axis] = 1U << (random() % 4);
    const bool is_extreme = random() % 4 == 0;
    level.lowest_voxel[axis] = is_extreme ? std::numeric_limits<std::int32_t>::min()
                                          : -static_cast<std::int32_t>(random() % 8);
    level.highest_voxel[axis] = is_extreme ? std::numeric_limits<std::int32_t>::max()
                                           : static_cast<std::int32_t>(random() % 8);
  }
  level.first_cell = static_cast<std::uint32_t>(random() % cell_capacity);
  return level;
}

TEST_CASE("A grid of random words never leads outside it and its visits are bounded",
          "[hostile_grid]") {
  constexpr std::size_t kSpheres = 40;
  constexpr std::uint32_t kMaxVisits = 50;
  std::mt19937_64 random(1);
  std::size_t cut = 0, visited = 0, out_of_range = 0, over_limit = 0;
  for (int round = 0; round < 4000; ++round) {
    GridView view;
    view.layout = grid_layout(0, kSpheres);
    view.shape.sphere_count = static_cast<std::uint32_t>(random() % (kSpheres + 1));
    view.shape.level_count = static_cast<std::uint32_t>(random() % 4);
    for (std::size_t i = 0; i < view.shape.level_count; ++i)
      view.shape.levels[i] = random_level(random, view.layout.cell_capacity);
    if (!is_consistent(view.shape, view.layout)) continue;
    // In a block of the exact size, so that the address sanitizer sees one word too far.
    std::vector<std::uint64_t> words(view.layout.total_words);
    // All numbers small, all of any size, or small starts of cells that lead to any swept bounds.
    constexpr std::uint64_t kSmall = 0x0000003F0000003FULL;
    for (std::size_t word = 0; word < words.size(); ++word) {
      const bool is_small = round % 3 == 0 || (round % 3 == 1 && word < view.layout.swept_bounds);
      words[word] = random() & (is_small ? kSmall : ~std::uint64_t{0});
    }
    view.words = words.data();

    const float bounding_radius_m = round % 8 ? 0.015F : kInfinity;
    const Query result = query(view, {{0.005F, 0.005F, 0.0F}, bounding_radius_m}, kMaxVisits);

    if (result.was_truncated) ++cut;
    visited += result.visited.size();
    if (result.visited.size() > kMaxVisits) ++over_limit;
    for (const std::uint32_t sphere : result.visited)
      if (sphere >= view.shape.sphere_count) ++out_of_range;
  }

  CHECK(out_of_range == 0);
  CHECK(over_limit == 0);
  CHECK(cut > 0);
  CHECK(visited > 0);
}

TEST_CASE("A query that is cut short says so, and one that is not is whole", "[hostile_grid]") {
  const RandomScene scene = random_scene(SceneKind::kScattered, 5, 250);
  const VoxelGrid grid = grid_of(scene);
  const SweptBound probe{{0.0F, 0.0F, 0.0F}, 0.3F};
  const Query whole = query(grid.view(), probe, kAllVisits);
  REQUIRE_FALSE(whole.was_truncated);
  REQUIRE(whole.visited.size() > 5);

  std::uint32_t enough = 0;
  while (query(grid.view(), probe, enough).was_truncated) {
    const Query part = query(grid.view(), probe, enough);
    REQUIRE(part.visited.size() <= enough);
    REQUIRE(std::equal(part.visited.begin(), part.visited.end(), whole.visited.begin()));
    ++enough;
  }
  CHECK(query(grid.view(), probe, enough).visited == whole.visited);
}

TEST_CASE("Cells that claim all spheres cost no more than the limit", "[hostile_grid]") {
  VoxelGrid grid = grid_of(random_scene(SceneKind::kScattered, 5, 250));
  const GridView view = grid.view();
  const auto starts = grid.words().subspan(view.layout.cell_starts);
  for (std::size_t word = 0; word < view.layout.swept_bounds - view.layout.cell_starts; ++word)
    starts[word] = word % 2 ? ~std::uint64_t{0} : std::uint64_t{0};

  const Query result = query(view, {{0.0F, 0.0F, 0.0F}, 0.5F}, 20);

  CHECK(result.was_truncated);
  CHECK(result.visited.size() <= 20);
}

TEST_CASE("A probe that is nowhere, everywhere or inside out is answered within the limit",
          "[hostile_grid]") {
  const VoxelGrid grid = grid_of(random_scene(SceneKind::kScattered, 5, 250));
  const std::uint32_t count = grid.view().shape.sphere_count;

  for (const SweptBound& nowhere :
       {SweptBound{{kNaN, 0.0F, 0.0F}, 0.1F}, SweptBound{{0.0F, 0.0F, 0.0F}, kNaN}})
    CHECK(query(grid.view(), nowhere, 1000).visited.empty());
  const SweptBound everywhere{{0.0F, 0.0F, 0.0F}, kInfinity};
  const Query all = query(grid.view(), everywhere, kAllVisits);
  CHECK_FALSE(all.was_truncated);
  CHECK(all.visited.size() == count);
  CHECK(query(grid.view(), everywhere, count / 2).was_truncated);
  CHECK(query(grid.view(), {{0.0F, 0.0F, 0.0F}, -1.0F}, 1000).visited.size() <= count);
}

TEST_CASE("A shape that does not fit its layout is called inconsistent", "[hostile_grid]") {
  const GridLayout layout = grid_layout(0, 40);
  proto::GridShape good{};
  good.sphere_count = 40;
  good.level_count = 2;
  for (std::size_t i = 0; i < 2; ++i)
    good.levels[i] = {{-4, -4, 0}, 0.01F, {3, 3, 4}, 0.02F, {8, 4, 5}, 0};
  good.levels[1].first_cell = static_cast<std::uint32_t>(layout.cell_capacity) - 160;
  REQUIRE(is_consistent(good, layout));

  const auto refused = [&](auto&& spoil) {
    proto::GridShape bad = good;
    spoil(bad);
    return !is_consistent(bad, layout);
  };
  CHECK(refused([](auto& shape) { shape.sphere_count = 41; }));
  CHECK(refused([](auto& shape) { shape.level_count = proto::kMaxLevels + 1; }));
  CHECK(refused([](auto& shape) { shape.level_count = 3; }));  // of no voxel
  const auto level_refused = [&](auto&& spoil) {
    return refused([&](auto& shape) { spoil(shape.levels[1]); });
  };
  CHECK(level_refused([](auto& level) { ++level.first_cell; }));
  CHECK(level_refused([](auto& level) { level.first_cell = 0xFFFFFFFF; }));
  CHECK(level_refused([](auto& level) { level.cells[0] = 0; }));
  CHECK(level_refused([](auto& level) { level.cells[1] = 16; }));
  CHECK(level_refused([](auto& level) { level.cells[1] = 3; }));  // repeats, and no power of two
  CHECK(level_refused([](auto& level) { level.cells = {0x80000000, 0x80000000, 4}; }));
  CHECK(level_refused([](auto& level) { level.cells = {0xFFFFFFFF, 0xFFFFFFFF, 0xFFFFFFFF}; }));
  CHECK(level_refused([](auto& level) { level.highest_voxel[2] = -1; }));
  CHECK(level_refused([](auto& level) {
    level.lowest_voxel[2] = std::numeric_limits<std::int32_t>::min();  // repeats over 5 cells
  }));
  for (const float voxel_m : {0.0F, -0.01F, kNaN, 1e-45F})
    CHECK(level_refused([&](auto& level) { level.voxel_m = voxel_m; }));
  for (const float bounding_radius_m : {-0.01F, kNaN, kInfinity})
    CHECK(level_refused([&](auto& level) { level.bounding_radius_m = bounding_radius_m; }));
}

}  // namespace
}  // namespace stillgrid::collision::hostile_grid_test
