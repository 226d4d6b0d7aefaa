#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "shared/collision/grid_query.hpp"
#include "tests/shared/collision/random_scene.hpp"

namespace stillgrid {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct Query {
  std::vector<std::uint32_t> visited;
  bool was_cut = false;
};

Query query(const GridView& view, const Box& box, std::uint32_t max_visits) {
  Query result;
  result.was_cut = for_each_candidate(
      view, box, max_visits,
      [&](std::uint32_t sphere, const RecordLine&) { result.visited.push_back(sphere); });
  return result;
}

TEST_CASE("A grid of random words never leads outside it and its visits are bounded",
          "[hostile_grid]") {
  constexpr std::size_t kSpheres = 40;
  constexpr std::uint32_t kMaxVisits = 50;
  std::mt19937_64 random(1);
  std::size_t cut = 0, visited = 0, out_of_range = 0, over_limit = 0;
  for (int round = 0; round < 2000; ++round) {
    GridView view;
    view.layout = grid_layout(0, kSpheres, log2_cells_for(kSpheres));
    view.shape.voxel_m = 0.01F;
    view.shape.log2_cells = {random() % 4 ? 3U : 0U, random() % 4 ? 2U : 8U, 0U};
    view.shape.sphere_count = static_cast<std::uint32_t>(random() % (kSpheres + 1));
    view.shape.long_count = static_cast<std::uint32_t>(random() % (view.shape.sphere_count + 1));
    view.shape.entry_count = static_cast<std::uint32_t>(
        random() % (view.shape.sphere_count * proto::kMaxVoxelsPerSphere + 1));
    if (!is_consistent(view.shape, view.layout)) continue;
    // In a block of the exact size, so that the address sanitizer sees one word too far.
    std::vector<std::uint64_t> words(view.layout.total_words);
    // All numbers small, all of any size, or small starts of cells that lead to any entries.
    constexpr std::uint64_t kSmall = 0x0000003F0000003FULL;
    for (std::size_t word = 0; word < words.size(); ++word) {
      const bool is_small = round % 3 == 0 || (round % 3 == 1 && word < view.layout.entries);
      words[word] = random() & (is_small ? kSmall : ~std::uint64_t{0});
    }
    view.words = words.data();

    const Box box{{-0.005F, -0.005F, -0.005F}, {0.015F, 0.015F, 0.005F}};  // 3 x 3 x 2 voxels
    const Query result = query(view, box, kMaxVisits);

    if (result.was_cut) ++cut;
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
  const RandomScene scene = random_scene(SceneKind::kScattered, 5);
  const StillGrid grid = grid_of(scene);
  const Box box{{-0.1F, -0.1F, -0.1F}, {0.1F, 0.1F, 0.1F}};
  const Query whole = query(grid.view(), box, kAllVisits);
  REQUIRE_FALSE(whole.was_cut);
  REQUIRE(whole.visited.size() > 10);

  std::uint32_t enough = 0;
  while (query(grid.view(), box, enough).was_cut) {
    const Query part = query(grid.view(), box, enough);
    REQUIRE(part.visited.size() <= enough);
    REQUIRE(std::equal(part.visited.begin(), part.visited.end(), whole.visited.begin()));
    ++enough;
  }
  CHECK(query(grid.view(), box, enough).visited == whole.visited);
}

TEST_CASE("A cell that claims all entries costs no more than the limit", "[hostile_grid]") {
  RandomScene scene = random_scene(SceneKind::kScattered, 5);
  StillGrid grid = grid_of(scene);
  const GridView view = grid.view();
  const auto starts = grid.words().subspan(view.layout.cell_starts);
  for (std::size_t word = 0; word < view.layout.entries - view.layout.cell_starts; ++word)
    starts[word] = word % 2 ? ~std::uint64_t{0} : std::uint64_t{0};

  // Cell 1 is among those that claim everything.
  const Query result = query(view, {{0, 0, 0}, {2.0F * view.shape.voxel_m, 0, 0}}, 20);

  CHECK(result.was_cut);
  CHECK(result.visited.size() <= 20);
}

TEST_CASE("A probe that is nowhere, everywhere or inside out is answered within the limit",
          "[hostile_grid]") {
  const RandomScene scene = random_scene(SceneKind::kScattered, 5);
  const StillGrid grid = grid_of(scene);
  const Box nowhere{{kNaN, 0.0F, kNaN}, {kNaN, kNaN, 0.0F}};
  const Box everywhere{{-kInfinity, -kInfinity, -kInfinity}, {kInfinity, kInfinity, kInfinity}};
  const Box inside_out{{1.0F, 1.0F, 1.0F}, {-1.0F, -1.0F, -1.0F}};

  CHECK(query(grid.view(), nowhere, 1000).visited.size() <= 1000);
  // More voxels than spheres: each sphere is looked at once instead.
  const std::uint32_t count = grid.view().shape.sphere_count;
  const Query all = query(grid.view(), everywhere, count + grid.view().shape.long_count);
  CHECK_FALSE(all.was_cut);
  CHECK(all.visited.size() == count);
  CHECK(query(grid.view(), everywhere, count / 2).was_cut);
  CHECK(query(grid.view(), inside_out, 1000).visited.size() == grid.view().shape.long_count);
}

TEST_CASE("A sphere that is nowhere does not keep the others from being found", "[hostile_grid]") {
  const auto axis = GENERATE(std::size_t{0}, std::size_t{1}, std::size_t{2});
  const float value = GENERATE(kNaN, kInfinity, -kInfinity);
  RandomScene scene = random_scene(SceneKind::kScattered, 9);
  const std::size_t others = scene.spheres.size();
  scene.spheres.push_back(still_sphere({0.0F, 0.0F, 0.0F}, 0.01F));
  scene.spheres.back().newest[0].position_m[axis] = value;
  scene.spheres.push_back(still_sphere({0.0F, 0.0F, 0.0F}, value));
  const StillGrid grid = grid_of(scene);

  const Box probe{{-0.05F, -0.05F, -0.05F}, {0.05F, 0.05F, 0.05F}};
  const Query result = query(grid.view(), probe, kAllVisits);

  std::size_t missed = 0, twice = 0;
  for (std::uint32_t b = 0; b < others; ++b) {
    const auto visits = std::count(result.visited.begin(), result.visited.end(), b);
    if (visits > 1) ++twice;
    if (visits == 0 && meet(swept_box(scene.spheres[b]), probe)) ++missed;
  }
  CHECK(missed == 0);
  CHECK(twice == 0);
}

TEST_CASE("A shape that does not fit its layout is called inconsistent", "[hostile_grid]") {
  const GridLayout layout = grid_layout(0, 40, 8);
  proto::GridShape good{};
  good.voxel_m = 0.01F;
  good.log2_cells = {3, 3, 2};
  good.sphere_count = 40;
  good.long_count = 40;
  good.entry_count = 40 * proto::kMaxVoxelsPerSphere;
  REQUIRE(is_consistent(good, layout));

  const auto refused = [&](auto&& spoil) {
    proto::GridShape bad = good;
    spoil(bad);
    return !is_consistent(bad, layout);
  };
  CHECK(refused([](auto& shape) { shape.sphere_count = 41; }));
  CHECK(refused([](auto& shape) { shape.long_count = 41; }));
  CHECK(refused([](auto& shape) { shape.entry_count += 1; }));
  CHECK(refused([](auto& shape) { shape.log2_cells = {3, 3, 3}; }));
  CHECK(refused([](auto& shape) { shape.log2_cells = {0xFFFFFFFF, 1, 0}; }));
  CHECK(refused([](auto& shape) { shape.log2_cells = {0xFFFFFFFF, 0xFFFFFFFF, 0xFFFFFFFF}; }));
  for (const float voxel_m : {0.0F, -0.01F, kNaN, 1e-45F})
    CHECK(refused([&](auto& shape) { shape.voxel_m = voxel_m; }));
}

}  // namespace
}  // namespace stillgrid
