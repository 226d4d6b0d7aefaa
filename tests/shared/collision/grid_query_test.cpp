#include "shared/collision/grid_query.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "shared/collision/sphere_history.hpp"
#include "tests/shared/collision/random_scene.hpp"
#include "tests/shared/collision/sphere_state.hpp"

namespace stillgrid::collision::grid_query_test {
namespace {

constexpr std::uint64_t kScenesOfAKind = 400;

/// How often each sphere was visited for a probe.
std::vector<int> visits_for(const GridView& view, const SweptBound& probe) {
  std::vector<int> visits(view.shape.sphere_count, 0);
  const bool was_truncated =
      for_each_candidate(view, probe, kAllVisits, [&](std::uint32_t sphere) { ++visits[sphere]; });
  REQUIRE_FALSE(was_truncated);
  return visits;
}

/// What a query answered, against every swept bound tried in turn.
struct Answers {
  std::size_t meeting = 0, missed = 0, twice = 0, idle = 0;  // idle: visited although apart

  void compare(const RandomScene& scene, const VoxelGrid& grid, const SweptBound& probe) {
    const std::vector<int> visits = visits_for(grid.view(), probe);
    for (std::size_t i = 0; i < scene.swept_bounds.size(); ++i) {
      const bool meets = meet_exactly(scene.swept_bounds[i], probe);
      if (meets) ++meeting;
      if (meets && visits[i] == 0) ++missed;
      if (visits[i] > 1) ++twice;
      // Rounding may let in a swept bound that all but touches.
      SweptBound larger = probe;
      larger.bounding_radius_m +=
          1e-5F * (larger.bounding_radius_m + scene.swept_bounds[i].bounding_radius_m);
      if (visits[i] > 0 && !meet_exactly(scene.swept_bounds[i], larger)) ++idle;
    }
  }
};

/// A probe at a swept bound of the scene or a little beside it, of up to three times its radius. As
/// bound_sphere() makes one, it is rounded outwards by what the test of two swept bounds may round
/// off.
SweptBound probe_near(const RandomScene& scene, std::mt19937_64& random) {
  std::uniform_real_distribution<float> share(-1.0F, 1.0F);
  const SweptBound& swept_bound = scene.swept_bounds[random() % scene.swept_bounds.size()];
  SweptBound probe = swept_bound;
  const bool is_exact = random() % 3 == 0;
  if (!is_exact) {
    for (float& x_m : probe.centre_m) x_m += 2.0F * share(random) * swept_bound.bounding_radius_m;
    probe.bounding_radius_m *= 1.5F + 1.5F * share(random);
  }
  return {probe.centre_m, probe.bounding_radius_m * 1.000001F};
}

TEST_CASE("Every sphere whose swept bound meets a probe is visited exactly once", "[grid_query]") {
  const auto kind = static_cast<SceneKind>(GENERATE(range(0, static_cast<int>(SceneKind::kCount))));
  Answers answers;
  std::size_t probes = 0;
  for (std::uint64_t seed = 0; seed < kScenesOfAKind; ++seed) {
    const RandomScene scene = random_scene(kind, seed);
    const VoxelGrid grid = grid_of(scene);
    std::mt19937_64 random(seed);
    for (std::size_t i = 0; i < std::min<std::size_t>(scene.swept_bounds.size(), 20); ++i) {
      answers.compare(scene, grid, probe_near(scene, random));
      ++probes;
    }
  }

  CHECK(answers.missed == 0);
  CHECK(answers.twice == 0);
  CHECK(answers.idle == 0);
  CHECK(answers.meeting > probes);  // the scenes are not idle
}

TEST_CASE("In a scene of 100,000 spheres too each one is visited exactly once", "[grid_query]") {
  const auto kind = static_cast<SceneKind>(GENERATE(range(0, static_cast<int>(SceneKind::kCount))));
  const RandomScene scene = random_scene(kind, 5, 100000);
  const VoxelGrid grid = grid_of(scene);
  std::mt19937_64 random(1);
  Answers answers;
  for (int i = 0; i < 20; ++i) answers.compare(scene, grid, probe_near(scene, random));

  CHECK(answers.missed == 0);
  CHECK(answers.twice == 0);
  CHECK(answers.idle == 0);
  CHECK(answers.meeting >= 20);
}

TEST_CASE("A sphere is found wherever a weighted mean of its snapshots shows it", "[grid_query]") {
  const double alpha = GENERATE(1.0, 0.5, 0.1, 0.0);
  std::size_t missed = 0, touched = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const auto records = random_histories(seed, 200);
    VoxelGrid grid(0, records.size());
    grid.enter(history_bounds(records), 1.0F);
    std::mt19937_64 random(seed);
    std::normal_distribution<double> direction;
    for (std::uint32_t i = 0; i < records.size(); ++i) {
      const auto vector = [](const std::array<float, 3>& p) {
        return Eigen::Vector3d(p[0], p[1], p[2]);
      };
      const Eigen::Vector3d shown_m = alpha * vector(records[i].newest.position_m) +
                                      (1.0 - alpha) * vector(records[i].before.position_m);
      const Eigen::Vector3d way(direction(random), direction(random), direction(random));
      constexpr double kProbe_m = 0.003;
      const double apart_m = 0.9999 * (kProbe_m + double{records[i].radius_m});
      bool found = false;
      for_each_candidate(grid.view(), bound_sphere(shown_m + apart_m * way.normalized(), kProbe_m),
                         kAllVisits, [&](std::uint32_t sphere) { found = found || sphere == i; });
      ++touched;
      missed += found ? 0 : 1;
    }
  }

  CHECK(missed == 0);
  CHECK(touched == 10000);
}

TEST_CASE("Where the grid repeats each sphere is still found once and where it is",
          "[grid_query]") {
  // At each of 16 places, whole periods apart, two spheres that overlap: all share their cells.
  RandomScene scene{{}, 1.0F};
  for (int place = 0; place < 16; ++place)
    for (int copy = 0; copy < 2; ++copy)
      scene.swept_bounds.push_back(
          {{256.0F * static_cast<float>(place) + 0.25F, 0.5F, 0.5F}, 0.5F});
  const VoxelGrid grid = grid_of(scene);
  REQUIRE(grid.view().shape.levels[0].cells[0] <= 256);

  std::size_t found = 0, others = 0;
  for (std::size_t i = 0; i < 32; ++i) {
    const std::vector<int> visits = visits_for(grid.view(), scene.swept_bounds[i]);
    if (visits[i] == 1 && visits[i ^ 1U] == 1) ++found;
    for (std::size_t other = 0; other < 32; ++other)
      if ((other | 1U) != (i | 1U)) others += static_cast<std::size_t>(visits[other]);
  }

  CHECK(found == 32);
  CHECK(others == 0);
}

TEST_CASE("A probe wider than the grid's period visits nothing twice", "[grid_query]") {
  const RandomScene scene = random_scene(SceneKind::kWide, 11, 300);
  const VoxelGrid grid = grid_of(scene);
  const proto::GridLevel level = grid.view().shape.levels[0];
  REQUIRE(static_cast<std::uint32_t>(level.highest_voxel[0] - level.lowest_voxel[0]) >
          4 * level.cells[0]);
  const float bounding_radius_m = GENERATE(1.0F, 10.0F, 100.0F);

  Answers answers;
  answers.compare(scene, grid, {{0.0F, 0.0F, 0.0F}, bounding_radius_m});

  CHECK(answers.missed == 0);
  CHECK(answers.twice == 0);
  CHECK(answers.idle == 0);
}

TEST_CASE("A probe at the far end of the floats finds nothing", "[grid_query]") {
  const VoxelGrid grid = grid_of(random_scene(SceneKind::kScattered, 12, 200));
  const float far_m = GENERATE(1e20F, -1e20F, 3e38F, -3e38F);
  const std::vector<int> visits = visits_for(grid.view(), {{far_m, 0.0F, far_m}, 1.0F});
  CHECK(std::count(visits.begin(), visits.end(), 0) == 200);
}

}  // namespace
}  // namespace stillgrid::collision::grid_query_test
