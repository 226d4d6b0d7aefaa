#include "shared/collision/voxel_grid.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include "shared/collision/grid_query.hpp"
#include "shared/collision/sphere_history.hpp"
#include "tests/shared/collision/random_scene.hpp"
#include "tests/shared/collision/sphere_state.hpp"

namespace stillgrid::collision::voxel_grid_test {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

std::size_t cells_of(const proto::GridLevel& level) {
  return std::size_t{level.cells[0]} * level.cells[1] * level.cells[2];
}

/// Swept bounds of a radius each, side by side.
std::vector<SweptBound> bounds_of_spheres(const std::vector<float>& bounding_radii_m) {
  std::vector<SweptBound> swept_bounds;
  float x_m = 0.0F;
  for (const float bounding_radius_m : bounding_radii_m) {
    swept_bounds.push_back({{x_m, 0.0F, 0.0F}, bounding_radius_m});
    x_m += bounding_radius_m;
  }
  return swept_bounds;
}

std::uint32_t levels_of(const std::vector<float>& bounding_radii_m, std::uint32_t octaves = 1) {
  VoxelGrid grid(0, bounding_radii_m.size());
  grid.enter(bounds_of_spheres(bounding_radii_m), 1.0F, octaves);
  return grid.view().shape.level_count;
}

TEST_CASE("Each sphere is entered once, by number within its cell, and the room is never outgrown",
          "[voxel_grid]") {
  const auto kind = static_cast<SceneKind>(GENERATE(range(0, static_cast<int>(SceneKind::kCount))));
  std::size_t misplaced = 0, disordered = 0, outgrown = 0, inconsistent = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const RandomScene scene = random_scene(kind, seed);
    const VoxelGrid grid = grid_of(scene);
    const GridView view = grid.view();
    if (!is_consistent(view.shape, view.layout)) ++inconsistent;
    std::vector<int> entered(scene.swept_bounds.size(), 0);
    std::size_t cells = 0;
    for (std::uint32_t i = 0; i < view.shape.level_count; ++i) {
      CHECK(view.shape.levels[i].first_cell == cells);
      cells += cells_of(view.shape.levels[i]);
    }
    if (cells > view.layout.cell_capacity) ++outgrown;
    const std::uint64_t* starts = view.words + view.layout.cell_starts;
    for (std::size_t cell = 0; cell < cells; ++cell)
      for (std::uint32_t i = double_buffer::load_u32(starts, cell);
           i < double_buffer::load_u32(starts, cell + 1); ++i) {
        const std::uint32_t sphere = grid.sorted_numbers()[i];
        ++entered[sphere];
        const SweptBound &sorted = grid.sorted_bounds()[i], &given = scene.swept_bounds[sphere];
        if (sorted.centre_m != given.centre_m ||
            sorted.bounding_radius_m != given.bounding_radius_m)
          ++misplaced;
        if (i > double_buffer::load_u32(starts, cell) && grid.sorted_numbers()[i - 1] >= sphere)
          ++disordered;
      }
    misplaced += static_cast<std::size_t>(
        std::count_if(entered.begin(), entered.end(), [](int times) { return times != 1; }));
  }
  CHECK(misplaced == 0);
  CHECK(disordered == 0);
  CHECK(outgrown == 0);
  CHECK(inconsistent == 0);
}

TEST_CASE("There is one level unless the reaches of a scene need more", "[voxel_grid]") {
  CHECK(levels_of(std::vector<float>(100, 0.01F)) == 1);
  std::vector<float> within_an_octave, two_octaves, two_decades;
  for (int i = 0; i < 100; ++i) {
    within_an_octave.push_back(0.0051F + 0.00004F * static_cast<float>(i));
    two_octaves.push_back(i < 50 ? 0.01F : 0.004F);
    two_decades.push_back(i < 50 ? 0.1F : 0.001F);
  }
  CHECK(levels_of(within_an_octave) == 1);
  CHECK(levels_of(two_octaves) == 2);
  CHECK(levels_of(two_decades) == 2);  // none for the octaves between
  two_decades.assign(100, 0.1F);
  two_decades.back() = 0.001F;
  CHECK(levels_of(two_decades) == 1);  // a level for one sphere would cost more than it saves

  std::vector<float> twenty_octaves;
  for (int octave = 0; octave < 20; ++octave)
    twenty_octaves.insert(twenty_octaves.end(), 50, std::ldexp(1.0F, -octave));
  CHECK(levels_of(twenty_octaves) == proto::kMaxLevels);
  CHECK(levels_of(twenty_octaves, 3) == 7);
  CHECK(levels_of(two_octaves, 2) == 1);
  two_octaves[7] = 0.0399F;  // of a third octave now
  CHECK(levels_of(two_octaves, 2) == 2);
  CHECK(levels_of(two_octaves, 4) == 1);
}

TEST_CASE("A level's voxels are the ratio times twice its longest radius", "[voxel_grid]") {
  const float ratio = GENERATE(0.25F, 1.0F, 3.0F);
  std::vector<float> bounding_radii_m(100, 0.008F);
  bounding_radii_m.resize(200, 0.0005F);
  bounding_radii_m[7] = 0.01F;
  const VoxelGrid grid = grid_of({bounds_of_spheres(bounding_radii_m), ratio});
  const proto::GridShape shape = grid.view().shape;
  REQUIRE(shape.level_count == 2);
  CHECK(shape.levels[0].bounding_radius_m == 0.01F);
  CHECK(shape.levels[0].voxel_m == Approx(ratio * 0.02));
  CHECK(shape.levels[1].bounding_radius_m == 0.0005F);
  CHECK(shape.levels[1].voxel_m == Approx(ratio * 0.001));
}

TEST_CASE("A sphere that is nowhere is refused by number and leaves the grid as it was",
          "[voxel_grid]") {
  const auto field = static_cast<std::size_t>(GENERATE(range(0, 4)));
  const float value = GENERATE(as<float>{}, kNaN, kInfinity, -kInfinity);
  RandomScene scene = random_scene(SceneKind::kScattered, 9, 50);
  VoxelGrid grid = grid_of(scene);
  const auto before = std::vector<std::uint64_t>(grid.words().begin(), grid.words().end());

  SweptBound& bad = scene.swept_bounds[17];
  (field < 3 ? bad.centre_m[field] : bad.bounding_radius_m) = value;

  CHECK_THROWS_WITH(grid.enter(scene.swept_bounds, 1.0F),
                    Catch::Contains("sphere 17 is nowhere") && Catch::Contains("expected"));
  CHECK(std::equal(before.begin(), before.end(), grid.words().begin()));
  CHECK(is_consistent(grid.view().shape, grid.layout()));
  CHECK(grid.view().shape.sphere_count == 50);
}

TEST_CASE("A sphere without radius is refused", "[voxel_grid]") {
  const float bounding_radius_m = GENERATE(0.0F, -0.01F);
  VoxelGrid grid(0, 1);
  CHECK_THROWS_AS(grid.enter(bounds_of_spheres({bounding_radius_m}), 1.0F), std::domain_error);
}

TEST_CASE("A swept bound holds its sphere in every snapshot and on the way between",
          "[voxel_grid]") {
  std::size_t outside = 0;
  for (const proto::SphereRecord& record : random_histories(3, 2000)) {
    const SweptBound swept_bound = bound_history(record);
    const auto add = [&](const std::array<float, 3>& a) {
      double squared_m2 = 0.0;
      for (std::size_t axis = 0; axis < 3; ++axis)
        squared_m2 += std::pow(double{a[axis]} - double{swept_bound.centre_m[axis]}, 2);
      if (std::sqrt(squared_m2) + double{record.radius_m} > double{swept_bound.bounding_radius_m})
        ++outside;
    };
    // A ball that holds the snapshots holds every weighted mean of them.
    add(record.newest.position_m);
    add(record.before.position_m);
  }
  CHECK(outside == 0);

  const Eigen::Vector3d from_m(1e5, -3.0, 0.125), to_m(1e5 + 0.3, -3.1, 0.5);
  const SweptBound path = bound_sweep(from_m, to_m, 0.01);
  for (const Eigen::Vector3d& end_m : {from_m, to_m}) {
    const Eigen::Vector3d centre_m =
        Eigen::Vector3f(path.centre_m[0], path.centre_m[1], path.centre_m[2]).cast<double>();
    CHECK((end_m - centre_m).norm() + 0.01 <= double{path.bounding_radius_m});
    CHECK((end_m - centre_m).norm() + 0.03 > double{path.bounding_radius_m});
  }
}

TEST_CASE(
    "A swept bound holds a sphere in the snapshots that it is in, and is finite if it is in none",
    "[voxel_grid]") {
  proto::SphereRecord record = static_sphere({5.0F, 6.0F, 7.0F}, 0.25F);
  const auto is_round_its_place = [&] {
    const SweptBound swept_bound = bound_history(record);
    return swept_bound.centre_m == std::array<float, 3>{5.0F, 6.0F, 7.0F} &&
           swept_bound.bounding_radius_m == Approx(0.25F).epsilon(1e-5);
  };
  record.before.position_m = {5.0F, kNaN, 7.0F};
  CHECK(is_round_its_place());
  std::swap(record.newest, record.before);
  CHECK(is_round_its_place());

  record.before.position_m = {kNaN, kNaN, kNaN};
  VoxelGrid grid(0, 1);
  grid.enter(std::array{bound_history(record)}, 1.0F);
  CHECK(bound_history(record).bounding_radius_m == Approx(0.25F).epsilon(1e-5));
  record.newest.position_m = {kInfinity, 0.0F, 0.0F};
  CHECK_THROWS_AS(grid.enter(std::array{bound_history(record)}, 1.0F), std::domain_error);
}

TEST_CASE("The first snapshot fills the history and each later one pushes it down",
          "[voxel_grid]") {
  VoxelGrid grid(0, 1);
  const auto push = [&](double x_m) {
    const std::array snapshot{sphere_state({x_m, 0.0, 0.0})};
    grid.push_snapshot(snapshot);
  };
  const auto history = [&] {
    const proto::SphereRecord& r = grid.records()[0];
    return std::array{r.newest.position_m[0], r.before.position_m[0]};
  };
  push(1.0);
  CHECK(history() == std::array{1.0F, 1.0F});
  push(2.0);
  push(3.0);
  CHECK(history() == std::array{3.0F, 2.0F});
}

TEST_CASE("Voxels never go backwards and far coordinates stay in range", "[voxel_grid]") {
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

TEST_CASE("The parts to publish are all that a reader of the grid needs", "[voxel_grid]") {
  const RandomScene scene = random_scene(SceneKind::kScattered, 21, 250);
  const VoxelGrid grid = grid_of(scene);
  std::vector<std::uint64_t> copy(grid.layout().total_words, ~std::uint64_t{0});
  for (const double_buffer::PayloadPart& part : grid.filled_parts()) {
    REQUIRE(part.first_word + part.words.size() <= copy.size());
    std::copy(part.words.begin(), part.words.end(),
              copy.begin() + static_cast<std::ptrdiff_t>(part.first_word));
  }

  const auto visited_in = [&](const GridView& view) {
    std::vector<std::uint32_t> visited;
    for (const SweptBound& probe : scene.swept_bounds)
      for_each_candidate(view, probe, kAllVisits,
                         [&](std::uint32_t sphere) { visited.push_back(sphere); });
    return visited;
  };
  GridView copied = grid.view();
  copied.words = copy.data();
  REQUIRE(visited_in(grid.view()).size() > 300);
  CHECK(visited_in(copied) == visited_in(grid.view()));
}

TEST_CASE("A grid filled again forgets what it held", "[voxel_grid]") {
  const RandomScene first = random_scene(SceneKind::kScattered, 30, 201);
  const RandomScene second = random_scene(SceneKind::kOnBorders, 31, 101);
  VoxelGrid grid = grid_of(first);
  grid.enter(second.swept_bounds, second.voxel_ratio);

  VoxelGrid fresh(0, first.swept_bounds.size());
  fresh.enter(second.swept_bounds, second.voxel_ratio);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto again = grid.filled_parts()[i].words, once = fresh.filled_parts()[i].words;
    REQUIRE(again.size() == once.size());
    // The last word of an odd count has a half that nobody reads.
    CHECK(std::equal(again.begin(), again.end() - std::min<std::ptrdiff_t>(1, std::ssize(again)),
                     once.begin()));
  }
}

TEST_CASE("An empty grid holds no candidate", "[voxel_grid]") {
  VoxelGrid grid(0, 0);
  grid.enter({}, 1.0F);
  int visited = 0;
  const bool was_truncated = for_each_candidate(grid.view(), {{0, 0, 0}, 1}, kAllVisits,
                                                [&](std::uint32_t) { ++visited; });
  CHECK(is_consistent(grid.view().shape, grid.layout()));
  CHECK(visited == 0);
  CHECK_FALSE(was_truncated);
}

}  // namespace
}  // namespace stillgrid::collision::voxel_grid_test
