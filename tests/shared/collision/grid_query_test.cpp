#include "shared/collision/grid_query.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <catch2/catch.hpp>
#include <utility>
#include <vector>

#include "tests/shared/collision/random_scene.hpp"

namespace stillgrid {
namespace {

constexpr std::uint64_t kScenesOfAKind = 80;

template <class Use>
void for_each_random_scene(Use&& use) {
  for (int kind = 0; kind < static_cast<int>(SceneKind::kCount); ++kind)
    for (std::uint64_t seed = 0; seed < kScenesOfAKind; ++seed)
      use(random_scene(static_cast<SceneKind>(kind), seed), seed);
}

/// How often each pair a < b was reported; the rest of the square stays zero.
class PairCounts {
 public:
  explicit PairCounts(const StillGrid& grid, std::size_t spheres)
      : spheres_(spheres), counts_(spheres * spheres) {
    for_each_pair(grid.view(), [&](std::uint32_t a, std::uint32_t b) {
      if (a >= b || b >= spheres_)
        ++disordered_;
      else
        ++counts_[a * spheres_ + b];
    });
  }
  [[nodiscard]] bool has(std::size_t a, std::size_t b) const {
    return counts_[a * spheres_ + b] > 0;
  }
  /// Pairs reported twice or not as a < b.
  [[nodiscard]] std::size_t faults() const {
    return disordered_ + static_cast<std::size_t>(std::count_if(
                             counts_.begin(), counts_.end(), [](int count) { return count > 1; }));
  }

 private:
  std::size_t spheres_, disordered_ = 0;
  std::vector<int> counts_;
};

/// How often each sphere was visited for a box.
std::vector<int> visits_for(const GridView& view, const Box& box) {
  std::vector<int> visits(view.shape.sphere_count, 0);
  for_each_candidate(view, box, kAllVisits,
                     [&](std::uint32_t sphere, const RecordLine&) { ++visits[sphere]; });
  return visits;
}

Box box_around(const std::array<float, 3>& centre_m, float half_m) {
  Box box{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.low_m[axis] = centre_m[axis] - half_m;
    box.high_m[axis] = centre_m[axis] + half_m;
  }
  return box;
}

/// Where a transition shows a sphere: a weighted sum of its images.
Eigen::Vector3d shown_m(const proto::SphereRecord& sphere, const std::array<double, 4>& weights) {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  for (std::size_t image = 0; image < 4; ++image) {
    const auto& at_m = position_of(sphere, image);
    sum_m += weights[image] * Eigen::Vector3d(at_m[0], at_m[1], at_m[2]);
  }
  return sum_m;
}

TEST_CASE("Every two spheres that overlap in an image are reported once", "[grid_query]") {
  std::size_t overlapping = 0, missed = 0, faults = 0;
  for_each_random_scene([&](const RandomScene& scene, std::uint64_t) {
    const auto& spheres = scene.spheres;
    const StillGrid grid = grid_of(scene);
    const PairCounts reported(grid, spheres.size());
    faults += reported.faults();
    for (std::size_t a = 0; a < spheres.size(); ++a)
      for (std::size_t b = a + 1; b < spheres.size(); ++b)
        for (std::size_t image = 0; image < proto::kHistoryLength; ++image)
          if (overlap(spheres[a], spheres[b], image)) {
            ++overlapping;
            if (!reported.has(a, b)) ++missed;
          }
  });

  CHECK(missed == 0);
  CHECK(faults == 0);
  CHECK(overlapping > 100000);  // the scenes are not idle
}

TEST_CASE("Spheres that overlap where a transition shows them are reported", "[grid_query]") {
  const std::array<double, 4> weights =
      GENERATE(std::array{0.5, 0.5, 0.0, 0.0}, std::array{0.1, 0.2, 0.3, 0.4},
               std::array{0.0, 0.0, 0.0, 1.0});
  std::size_t overlapping = 0, missed = 0;
  for (std::uint64_t seed = 0; seed < kScenesOfAKind; ++seed) {
    const auto [spheres, voxel_m] = random_scene(SceneKind::kScattered, seed);
    const PairCounts reported(grid_of({spheres, voxel_m}), spheres.size());
    for (std::size_t a = 0; a < spheres.size(); ++a)
      for (std::size_t b = a + 1; b < spheres.size(); ++b) {
        const double reach_m = double{spheres[a].radius_m} + double{spheres[b].radius_m};
        if ((shown_m(spheres[a], weights) - shown_m(spheres[b], weights)).norm() < reach_m) {
          ++overlapping;
          if (!reported.has(a, b)) ++missed;
        }
      }
  }

  CHECK(missed == 0);
  CHECK(overlapping > 1000);
}

TEST_CASE("Every sphere whose swept box meets a probe is visited once", "[grid_query]") {
  std::size_t meeting = 0, missed = 0, twice = 0;
  for_each_random_scene([&](const RandomScene& scene, std::uint64_t seed) {
    const StillGrid grid = grid_of(scene);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<float> voxels(0.0F, 6.0F);
    for (std::size_t i = 0; i < std::min<std::size_t>(scene.spheres.size(), 20); ++i) {
      const Box probe =
          box_around(scene.spheres[i].newest[0].position_m, voxels(random) * scene.voxel_m / 2.0F);
      const std::vector<int> visits = visits_for(grid.view(), probe);
      for (std::size_t b = 0; b < scene.spheres.size(); ++b) {
        const bool meets = meet(swept_box(scene.spheres[b]), probe);
        if (meets) ++meeting;
        if (meets && visits[b] == 0) ++missed;
        if (visits[b] > 1) ++twice;
      }
    }
  });

  CHECK(missed == 0);
  CHECK(twice == 0);
  CHECK(meeting > 50000);
}

TEST_CASE("Where the grid repeats each sphere is still found once and where it is",
          "[grid_query]") {
  // Two spheres that overlap at each of 16 places, whole periods apart: all share their cells.
  RandomScene scene{{}, 1.0F};
  for (int place = 0; place < 16; ++place)
    for (int copy = 0; copy < 2; ++copy)
      scene.spheres.push_back(
          still_sphere({256.0F * static_cast<float>(place) + 0.5F, 0.5F, 0.5F}, 0.25F));
  const StillGrid grid = grid_of(scene);
  REQUIRE(grid.view().shape.log2_cells[0] <= 8);

  std::size_t found_as_pair = 0, found_by_probe = 0, twice = 0;
  const PairCounts reported(grid, scene.spheres.size());
  for (std::size_t i = 0; i < 32; i += 2)
    if (reported.has(i, i + 1)) ++found_as_pair;
  for (std::size_t i = 0; i < 32; ++i) {
    const Box probe = box_around(scene.spheres[i].newest[0].position_m, 0.25F);
    const std::vector<int> visits = visits_for(grid.view(), probe);
    if (visits[i] == 1 && visits[i ^ 1] == 1) ++found_by_probe;
    twice += static_cast<std::size_t>(
        std::count_if(visits.begin(), visits.end(), [](int count) { return count > 1; }));
  }

  CHECK(found_as_pair == 16);
  CHECK(reported.faults() == 0);
  CHECK(found_by_probe == 32);
  CHECK(twice == 0);
}

TEST_CASE("A probe wider than the grid's period visits nothing twice", "[grid_query]") {
  const RandomScene scene = random_scene(SceneKind::kWide, 11);
  const StillGrid grid = grid_of(scene);
  REQUIRE(grid.view().shape.log2_cells[0] <= 5);

  const Box probe = box_around({0.0F, 0.0F, 0.0F}, 40.0F * scene.voxel_m);  // 80 voxels
  const std::vector<int> visits = visits_for(grid.view(), probe);

  REQUIRE_FALSE(visits.empty());
  CHECK(*std::max_element(visits.begin(), visits.end()) <= 1);
}

TEST_CASE("A sphere on the long list is paired once with every other", "[grid_query]") {
  RandomScene scene{{}, 0.01F};
  for (int i = 0; i < 20; ++i) {
    const bool is_large = i % 3 == 0;
    scene.spheres.push_back(
        still_sphere({0.05F * static_cast<float>(i), 0.0F, 0.0F}, is_large ? 0.5F : 0.002F));
  }
  const StillGrid grid = grid_of(scene);
  REQUIRE(grid.view().shape.long_count == 7);

  const PairCounts reported(grid, scene.spheres.size());

  CHECK(reported.faults() == 0);
  for (std::size_t a = 0; a < 20; ++a)
    for (std::size_t b = a + 1; b < 20; ++b)
      if (a % 3 == 0 || b % 3 == 0) CHECK(reported.has(a, b));
}

}  // namespace
}  // namespace stillgrid
