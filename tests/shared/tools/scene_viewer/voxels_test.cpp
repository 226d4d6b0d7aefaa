#include "shared/tools/scene_viewer/voxels.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tests/shared/publication/small_scene.hpp"

namespace stillgrid::scene_viewer::voxels_test {
namespace {

publication::SceneView view_of(const publication::TestSession& session) {
  return publication::SceneView(*publication::SegmentReader::open(
      session.name(), proto::SegmentKind::kScene, proto::kSceneLayoutHash));
}

bool holds(const OccupiedVoxel& voxel, const proto::SweptBound& swept_bound) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (std::abs(swept_bound.centre_m[axis] - voxel.centre_m[axis]) > 0.5001F * voxel.edge_m)
      return false;
  return true;
}

TEST_CASE("Each sphere is in one occupied voxel, that of its cover's centre", "[voxels]") {
  const publication::TestSession session;
  publication::SmallSceneWriter writer(session);
  writer.publish_next();
  writer.publish_next();
  const publication::SceneView view = view_of(session);
  const auto snapshot = reading::read_snapshot(view, 1000);
  REQUIRE(snapshot);
  REQUIRE(snapshot->swept_bounds.size() == publication::kMovingSpheres);

  const auto voxels = occupied_voxels(snapshot->header.grid, snapshot->swept_bounds);

  CHECK(voxels.size() == snapshot->occupancy.occupied_cells);
  std::uint32_t spheres = 0;
  for (const OccupiedVoxel& voxel : voxels) {
    spheres += voxel.spheres;
    CHECK(std::count_if(snapshot->swept_bounds.begin(), snapshot->swept_bounds.end(),
                        [&](const reading::LevelBound& entry) {
                          return holds(voxel, entry.swept_bound);
                        }) == voxel.spheres);
  }
  CHECK(spheres == publication::kMovingSpheres);
}

TEST_CASE("Small and large spheres are in voxels of their own levels", "[voxels]") {
  proto::GridShape grid{};
  grid.level_count = 2;
  grid.levels[0].voxel_m = 1.0F;
  grid.levels[1].voxel_m = 0.25F;
  const std::vector<reading::LevelBound> swept_bounds = {{{{0.6F, 0.6F, -0.1F}, 0.5F}, 0},
                                                         {{{0.6F, 0.6F, -0.1F}, 0.1F}, 1},
                                                         {{{0.7F, 0.7F, -0.2F}, 0.1F}, 1}};
  const auto voxels = occupied_voxels(grid, swept_bounds);
  REQUIRE(voxels.size() == 2);
  CHECK(voxels[0].centre_m == std::array{0.5F, 0.5F, -0.5F});
  CHECK(voxels[1].centre_m == std::array{0.625F, 0.625F, -0.125F});
  CHECK(voxels[1].edge_m == 0.25F);
  CHECK(voxels[1].spheres == 2);
}

TEST_CASE("Covers that are nowhere are in no voxel", "[voxels]") {
  proto::GridShape grid{};
  grid.level_count = 1;
  grid.levels[0].voxel_m = 1.0F;
  const float nan = std::nanf(""), far = std::numeric_limits<float>::infinity();
  CHECK(occupied_voxels(grid, std::vector<reading::LevelBound>{{{{nan, 0.0F, 0.0F}, 1.0F}, 0},
                                                               {{{0.0F, far, 0.0F}, 1.0F}, 0}})
            .empty());
}

}  // namespace
}  // namespace stillgrid::scene_viewer::voxels_test
