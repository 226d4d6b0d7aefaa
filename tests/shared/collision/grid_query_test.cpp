#include "shared/collision/grid_query.hpp"

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

/// The sphere as a transition shows it: a weighted sum of its images.
proto::SphereRecord shown(const proto::SphereRecord& sphere, const std::array<float, 4>& weights) {
  proto::SphereRecord result = sphere;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double sum_m = 0.0;
    for (std::size_t image = 0; image < 4; ++image)
      sum_m += double{weights[image]} * double{position_of(sphere, image)[axis]};
    const Box box = swept_box(sphere);  // rounding to float must not leave the images' range
    result.newest[0].position_m[axis] =
        std::clamp(static_cast<float>(sum_m), box.low_m[axis] + sphere.radius_m,
                   std::max(box.low_m[axis] + sphere.radius_m, box.high_m[axis] - sphere.radius_m));
  }
  return result;
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
            missed += reported.has(a, b) ? 0 : 1;
          }
  });

  CHECK(missed == 0);
  CHECK(faults == 0);
  CHECK(overlapping > 100000);  // the scenes are not idle
}

TEST_CASE("Spheres that overlap where a transition shows them are reported", "[grid_query]") {
  const std::array<float, 4> weights =
      GENERATE(std::array{0.5F, 0.5F, 0.0F, 0.0F}, std::array{0.1F, 0.2F, 0.3F, 0.4F},
               std::array{0.0F, 0.0F, 0.0F, 1.0F});
  std::size_t overlapping = 0, missed = 0;
  for (std::uint64_t seed = 0; seed < kScenesOfAKind; ++seed) {
    const RandomScene scene = random_scene(SceneKind::kScattered, seed);
    const StillGrid grid = grid_of(scene);
    const PairCounts reported(grid, scene.spheres.size());
    std::vector<proto::SphereRecord> displayed;
    for (const auto& sphere : scene.spheres) displayed.push_back(shown(sphere, weights));
    for (std::size_t a = 0; a < displayed.size(); ++a)
      for (std::size_t b = a + 1; b < displayed.size(); ++b)
        if (overlap(displayed[a], displayed[b], 0)) {
          ++overlapping;
          missed += reported.has(a, b) ? 0 : 1;
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
        meeting += meets ? 1 : 0;
        missed += meets && visits[b] == 0 ? 1 : 0;
        twice += visits[b] > 1 ? 1 : 0;
      }
    }
  });

  CHECK(missed == 0);
  CHECK(twice == 0);
  CHECK(meeting > 50000);
}

TEST_CASE("A probe far from everything visits no sphere but the long ones", "[grid_query]") {
  const RandomScene scene = random_scene(SceneKind::kScattered, 7);
  const StillGrid grid = grid_of(scene);
  const float away_m = 1000.0F * scene.voxel_m;
  const Box probe = box_around({away_m, away_m, away_m}, scene.voxel_m);

  const std::vector<int> visits = visits_for(grid.view(), probe);

  const auto visited = std::count(visits.begin(), visits.end(), 1);
  CHECK(visited == static_cast<std::ptrdiff_t>(grid.view().shape.long_count));
}

TEST_CASE("Where the grid repeats each sphere is still found once and where it is",
          "[grid_query]") {
  // Spheres of one voxel's radius, whole periods apart: all share the same cells.
  constexpr float kPeriod_m = 4.0F;
  RandomScene scene{{}, 1.0F};
  for (int i = 0; i < 16; ++i)
    for (int copy = 0; copy < 2; ++copy)  // two that overlap at each place
      scene.spheres.push_back(
          still_sphere({static_cast<float>(i) * 64.0F * kPeriod_m, 0.5F, 0.5F}, 0.25F));
  for (int i = 0; i < 8; ++i)  // makes the scene as wide along the other axes
    scene.spheres.push_back(still_sphere(
        {0.5F, static_cast<float>(i) * 1000.5F, static_cast<float>(-i) * 777.5F}, 0.25F));
  const StillGrid grid = grid_of(scene);
  const auto& shape = grid.view().shape;
  REQUIRE((1U << shape.log2_cells[0]) < 16U * 256U);

  std::size_t overlapping = 0;
  const PairCounts reported(grid, scene.spheres.size());
  for (std::size_t i = 0; i < 32; i += 2) overlapping += reported.has(i, i + 1) ? 1 : 0;
  CHECK(overlapping == 16);
  CHECK(reported.faults() == 0);

  for (std::size_t i = 0; i < 32; ++i) {
    const Box probe = box_around(scene.spheres[i].newest[0].position_m, 0.25F);
    const std::vector<int> visits = visits_for(grid.view(), probe);
    for (std::size_t b = 0; b < 32; ++b) CHECK(visits[b] == (b / 2 == i / 2 ? 1 : 0));
  }
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
