#include "shared/collision/still_grid.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "shared/collision/grid_query.hpp"
#include "tests/shared/collision/random_scene.hpp"

namespace stillgrid {
namespace {

std::vector<std::uint32_t> spheres_in_cell(const GridView& view, std::size_t cell) {
  const std::uint64_t* starts = view.words + view.layout.cell_starts;
  std::vector<std::uint32_t> spheres;
  for (std::uint32_t i = load_u32(starts, cell); i < load_u32(starts, cell + 1); ++i)
    spheres.push_back(load_u32(view.words + view.layout.entries, i));
  return spheres;
}

std::size_t cells_of(const GridView& view) {
  const auto& log2_cells = view.shape.log2_cells;
  return std::size_t{1} << (log2_cells[0] + log2_cells[1] + log2_cells[2]);
}

std::set<std::uint32_t> long_list_of(const GridView& view) {
  std::set<std::uint32_t> spheres;
  for (std::uint32_t i = 0; i < view.shape.long_count; ++i)
    spheres.insert(load_u32(view.words + view.layout.long_list, i));
  return spheres;
}

/// Cells of the voxels that a sphere's swept box meets.
std::set<std::size_t> cells_met(const GridView& view, const proto::SphereRecord& sphere) {
  const float inverse_voxel_per_m = 1.0F / view.shape.voxel_m;
  const Box box = swept_box(sphere);
  Voxel low{}, high{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low[axis] = voxel_index(box.low_m[axis], inverse_voxel_per_m);
    high[axis] = voxel_index(box.high_m[axis], inverse_voxel_per_m);
  }
  std::set<std::size_t> cells;
  for (int z = low[2]; z <= high[2]; ++z)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int x = low[0]; x <= high[0]; ++x)
        cells.insert(cell_of({x, y, z}, view.shape.log2_cells));
  return cells;
}

TEST_CASE("A sphere is entered once in each voxel that its swept box meets and in no other",
          "[still_grid]") {
  const auto kind = GENERATE(SceneKind::kScattered, SceneKind::kOnBorders, SceneKind::kWide);
  const std::uint64_t seed = GENERATE(range(3U, 13U));
  const RandomScene scene = random_scene(kind, seed);
  const StillGrid grid = grid_of(scene);
  const GridView view = grid.view();
  REQUIRE(is_consistent(view.shape, view.layout));

  std::vector<std::set<std::size_t>> entered(scene.spheres.size());
  std::size_t entries = 0;
  bool is_ascending = true;
  for (std::size_t cell = 0; cell < cells_of(view); ++cell) {
    const auto spheres = spheres_in_cell(view, cell);
    is_ascending = is_ascending && std::is_sorted(spheres.begin(), spheres.end());
    for (const std::uint32_t sphere : spheres) {
      entered[sphere].insert(cell);
      ++entries;
    }
  }
  const std::set<std::uint32_t> long_ones = long_list_of(view);
  std::size_t expected_entries = 0;
  for (std::uint32_t i = 0; i < scene.spheres.size(); ++i) {
    const auto expected =
        long_ones.count(i) ? std::set<std::size_t>{} : cells_met(view, scene.spheres[i]);
    expected_entries += expected.size();
    REQUIRE(entered[i] == expected);
  }
  CHECK(entries == expected_entries);
  CHECK(view.shape.entry_count == entries);
  CHECK(is_ascending);
}

TEST_CASE("Equal spheres make N (1 + 1/r)^3 entries", "[still_grid]") {
  // r: edge of a voxel over a sphere's diameter.
  const double r = GENERATE(0.5, 0.75, 1.0, 1.5, 2.0, 3.0);
  constexpr std::size_t kSpheres = 30000;
  constexpr float kDiameter_m = 0.02F;
  std::mt19937_64 random(2);
  std::uniform_real_distribution<float> place_m(0.0F, 1.0F);
  StillGrid grid(0, kSpheres);
  for (auto& sphere : grid.records())
    sphere = still_sphere({place_m(random), place_m(random), place_m(random)}, kDiameter_m / 2.0F);

  grid.fill(kSpheres, static_cast<float>(r) * kDiameter_m);

  const double expected = static_cast<double>(kSpheres) * std::pow(1.0 + 1.0 / r, 3.0);
  CHECK(grid.view().shape.long_count == 0);
  CHECK(static_cast<double>(grid.view().shape.entry_count) == Approx(expected).epsilon(0.03));
}

TEST_CASE("A sphere in more than 64 voxels is on the long list alone", "[still_grid]") {
  // Voxels of 1 m; a box from 0.5 on that reaches into `voxels` of them along each axis.
  const auto sphere_over = [](float voxels) {
    const float radius_m = (voxels - 1.0F) / 2.0F;
    return still_sphere({0.5F + radius_m, 0.5F + radius_m, 0.5F + radius_m}, radius_m);
  };
  StillGrid grid(0, 2);
  grid.records()[0] = sphere_over(4.0F);
  grid.records()[1] = sphere_over(5.0F);

  grid.fill(2, 1.0F);

  CHECK(grid.view().shape.entry_count == 64);
  CHECK(long_list_of(grid.view()) == std::set<std::uint32_t>{1});
}

TEST_CASE("A huge sphere is as quick to enter as a small one", "[still_grid]") {
  const float radius_m = GENERATE(1.0F, 1e3F, 1e9F, std::numeric_limits<float>::max(), INFINITY);
  StillGrid grid(0, 1);
  grid.records()[0] = still_sphere({0.0F, 0.0F, 0.0F}, radius_m);

  grid.fill(1, 1e-6F);

  CHECK(grid.view().shape.long_count == 1);
  CHECK(grid.view().shape.entry_count == 0);
}

TEST_CASE("The swept box holds the sphere in every image", "[still_grid]") {
  proto::SphereRecord sphere = still_sphere({0.0F, 0.0F, 0.0F}, 0.5F);
  sphere.newest[0].position_m = {1.0F, 0.0F, 0.0F};
  sphere.newest[1].position_m = {0.0F, -2.0F, 0.0F};
  sphere.older[0].position_m = {0.0F, 0.0F, 3.0F};
  sphere.older[1].position_m = {-4.0F, 0.0F, 0.0F};

  const Box box = swept_box(sphere);

  CHECK(box.low_m == std::array{-4.5F, -2.5F, -0.5F});
  CHECK(box.high_m == std::array{1.5F, 0.5F, 3.5F});
}

TEST_CASE("Voxels never go backwards and far coordinates stay in range", "[still_grid]") {
  constexpr std::int32_t kFarthest = 1 << 30;
  CHECK(voxel_index(0.0F, 100.0F) == 0);
  CHECK(voxel_index(-0.0F, 100.0F) == 0);
  CHECK(voxel_index(-1e-30F, 100.0F) == -1);
  CHECK(voxel_index(1.0F, 1.0F) == 1);
  CHECK(voxel_index(std::nextafter(1.0F, 0.0F), 1.0F) == 0);
  CHECK(voxel_index(1e30F, 100.0F) == kFarthest);
  CHECK(voxel_index(-INFINITY, 100.0F) == -kFarthest);
  CHECK(std::abs(voxel_index(std::nanf(""), 100.0F)) <= kFarthest);

  std::mt19937_64 random(3);
  std::uniform_real_distribution<float> coordinate_m(-1e6F, 1e6F);
  std::vector<float> coordinates_m(10000);
  for (float& x_m : coordinates_m) x_m = coordinate_m(random);
  std::sort(coordinates_m.begin(), coordinates_m.end());
  CHECK(std::is_sorted(coordinates_m.begin(), coordinates_m.end(), [](float a_m, float b_m) {
    return voxel_index(a_m, 1.0F / 0.007F) < voxel_index(b_m, 1.0F / 0.007F);
  }));
}

TEST_CASE("The parts to publish are all that a reader of the grid needs", "[still_grid]") {
  const RandomScene scene = random_scene(SceneKind::kScattered, 21);
  const StillGrid grid = grid_of(scene);
  std::vector<std::uint64_t> copy(grid.layout().total_words, ~std::uint64_t{0});
  for (const PayloadPart& part : grid.filled_parts()) {
    REQUIRE(part.first_word + part.words.size() <= copy.size());
    std::copy(part.words.begin(), part.words.end(),
              copy.begin() + static_cast<std::ptrdiff_t>(part.first_word));
  }

  const auto pairs_of = [](const GridView& view) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
    for_each_pair(view, [&](std::uint32_t a, std::uint32_t b) { pairs.emplace_back(a, b); });
    return pairs;
  };
  GridView copied = grid.view();
  copied.words = copy.data();
  REQUIRE(pairs_of(grid.view()).size() > 100);
  CHECK(pairs_of(copied) == pairs_of(grid.view()));
}

TEST_CASE("A grid filled again forgets what it held", "[still_grid]") {
  const RandomScene first = random_scene(SceneKind::kScattered, 30);
  RandomScene second = random_scene(SceneKind::kOnBorders, 31);
  second.spheres.resize(first.spheres.size() / 2, still_sphere({0.0F, 0.0F, 0.0F}, 0.01F));
  StillGrid grid = grid_of(first);
  std::copy(second.spheres.begin(), second.spheres.end(), grid.records().begin());

  grid.fill(second.spheres.size(), second.voxel_m);

  StillGrid fresh(0, first.spheres.size());
  std::copy(second.spheres.begin(), second.spheres.end(), fresh.records().begin());
  fresh.fill(second.spheres.size(), second.voxel_m);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto again = grid.filled_parts()[i].words, once = fresh.filled_parts()[i].words;
    // The last word of an odd count has a half that nobody reads.
    REQUIRE(again.size() == once.size());
    CHECK(std::equal(again.begin(), again.end() - std::min<std::ptrdiff_t>(1, std::ssize(again)),
                     once.begin()));
  }
}

TEST_CASE("An empty grid holds no pair and no candidate", "[still_grid]") {
  StillGrid grid(0, 0);
  grid.fill(0, 0.01F);
  int reported = 0;

  for_each_pair(grid.view(), [&](auto...) { ++reported; });
  const bool was_cut = for_each_candidate(grid.view(), {{-1, -1, -1}, {1, 1, 1}}, kAllVisits,
                                          [&](auto...) { ++reported; });

  CHECK(is_consistent(grid.view().shape, grid.layout()));
  CHECK(reported == 0);
  CHECK_FALSE(was_cut);
}

}  // namespace
}  // namespace stillgrid
