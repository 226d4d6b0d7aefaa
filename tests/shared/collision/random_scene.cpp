#include "tests/shared/collision/random_scene.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/shared/collision/sphere_state.hpp"

namespace stillgrid::collision {
namespace {

using Random = std::mt19937_64;

float uniform(Random& random, float low, float high) {
  return std::uniform_real_distribution<float>(low, high)(random);
}

/// Uniform in the logarithm: as many small ones as large ones.
float decades(Random& random, float low, float high) {
  return std::exp(uniform(random, std::log(low), std::log(high)));
}

std::array<float, 3> somewhere(Random& random, float low_m, float high_m) {
  return {uniform(random, low_m, high_m), uniform(random, low_m, high_m),
          uniform(random, low_m, high_m)};
}

constexpr float kContactDistance_m = 1.0F / 64.0F;  // of equal swept bounds, a power of two

SweptBound random_bound(SceneKind kind, Random& random, float spread_m) {
  switch (kind) {
    case SceneKind::kOnBorders: {
      std::uniform_int_distribution<int> place(-12, 12);
      const auto border_m = [&] { return static_cast<float>(place(random)) * kContactDistance_m; };
      return {{border_m(), border_m(), border_m()}, kContactDistance_m};
    }
    case SceneKind::kCoincident: {
      std::uniform_int_distribution<int> place(-2, 2);
      const auto shared_m = [&] { return static_cast<float>(place(random)) * 0.0371F; };
      return {{shared_m(), shared_m(), shared_m()}, decades(random, 0.001F, 0.1F)};
    }
    case SceneKind::kFarAway: {
      auto at_m = somewhere(random, -spread_m, spread_m);
      for (float& coordinate_m : at_m) coordinate_m -= 1e6F;
      return {at_m, decades(random, 0.01F, 1.0F)};
    }
    case SceneKind::kWide:
      return {somewhere(random, -spread_m, spread_m), kContactDistance_m};
    default:
      return {somewhere(random, -spread_m, spread_m), decades(random, 0.001F, 0.1F)};
  }
}

}  // namespace

RandomScene random_scene(SceneKind kind, std::uint64_t seed, std::size_t count) {
  Random random(seed * static_cast<std::uint64_t>(SceneKind::kCount) +
                static_cast<std::uint64_t>(kind));
  RandomScene scene;
  // On borders voxels are two reaches or one wide, in binary, so that faces lie on borders exactly.
  constexpr std::array kRatios{0.25F, 0.5F, 1.0F, 1.5F, 2.5F};
  scene.voxel_ratio = kind == SceneKind::kOnBorders ? 1.0F / static_cast<float>(1U + seed % 2)
                                                    : kRatios[random() % kRatios.size()];
  // A thousandth of the volume of a wide scene is cells; the others grow with their number.
  const float grown = std::cbrt(static_cast<float>(std::max<std::size_t>(count, 300)) / 300.0F);
  const float spread_m = kind == SceneKind::kWide ? 30.0F * grown : 0.5F * grown;
  for (std::size_t i = 0; i < count; ++i)
    scene.swept_bounds.push_back(random_bound(kind, random, spread_m));
  if (kind == SceneKind::kWide)  // neighbours, or nothing would ever touch
    for (std::size_t i = 1; i < count; i += 2) {
      scene.swept_bounds[i] = scene.swept_bounds[i - 1];
      scene.swept_bounds[i].centre_m[0] += uniform(random, 0.0F, 3.0F * kContactDistance_m);
    }
  return scene;
}

RandomScene random_scene(SceneKind kind, std::uint64_t seed) {
  Random random(seed);
  return random_scene(kind, seed,
                      seed < 3 ? seed : std::uniform_int_distribution<std::size_t>(0, 300)(random));
}

VoxelGrid grid_of(const RandomScene& scene) {
  VoxelGrid grid(0, scene.swept_bounds.size());
  grid.enter(scene.swept_bounds, scene.voxel_ratio);
  return grid;
}

std::vector<proto::SphereRecord> random_histories(std::uint64_t seed, std::size_t count) {
  Random random(seed);
  std::vector<proto::SphereRecord> records;
  for (std::size_t i = 0; i < count; ++i) {
    std::array<float, 3> at_m = somewhere(random, -0.5F, 0.5F);
    records.push_back(static_sphere(at_m, decades(random, 0.001F, 0.1F)));
    const float step_m = decades(random, 0.001F, 0.1F);
    proto::SphereRecord& sphere = records.back();
    for (float& coordinate_m : at_m) coordinate_m += uniform(random, -step_m, step_m);
    sphere.before.position_m = at_m;
  }
  return records;
}

bool meet_exactly(const SweptBound& a, const SweptBound& b) {
  double distance_squared_m2 = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double apart_m = double{a.centre_m[axis]} - double{b.centre_m[axis]};
    distance_squared_m2 += apart_m * apart_m;
  }
  const double bounding_radius_m = double{a.bounding_radius_m} + double{b.bounding_radius_m};
  return distance_squared_m2 <= bounding_radius_m * bounding_radius_m;
}

}  // namespace stillgrid::collision
