#include "tests/shared/collision/random_scene.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid {
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

/// Images apart from each other by up to `step_m` along each axis.
void move_through_history(Random& random, proto::SphereRecord& sphere, float step_m) {
  std::array<float, 3> at_m = sphere.newest[0].position_m;
  for (proto::SphereImage* image : {&sphere.newest[1], &sphere.older[0], &sphere.older[1]}) {
    for (float& coordinate_m : at_m) coordinate_m += uniform(random, -step_m, step_m);
    image->position_m = at_m;
  }
}

proto::SphereRecord random_sphere(SceneKind kind, Random& random, float voxel_m, float spread_m) {
  switch (kind) {
    case SceneKind::kOnBorders: {
      std::uniform_int_distribution<int> place(-6, 6), size(1, 4);
      const auto border_m = [&] { return static_cast<float>(place(random)) * voxel_m; };
      return still_sphere({border_m(), border_m(), border_m()},
                          static_cast<float>(size(random)) * voxel_m / 2.0F);
    }
    case SceneKind::kCoincident: {
      std::uniform_int_distribution<int> place(-2, 2);
      const auto shared_m = [&] { return static_cast<float>(place(random)) * 0.0371F; };
      return still_sphere({shared_m(), shared_m(), shared_m()}, decades(random, 0.001F, 0.1F));
    }
    case SceneKind::kFarAway: {
      auto at_m = somewhere(random, -spread_m, spread_m);
      for (float& coordinate_m : at_m) coordinate_m -= 1e6F;
      return still_sphere(at_m, decades(random, 0.01F, 1.0F));
    }
    default: {
      proto::SphereRecord sphere =
          still_sphere(somewhere(random, -spread_m, spread_m), decades(random, 0.001F, 0.1F));
      if (random() % 2 == 0) move_through_history(random, sphere, decades(random, 0.001F, 0.1F));
      return sphere;
    }
  }
}

}  // namespace

RandomScene random_scene(SceneKind kind, std::uint64_t seed) {
  Random random(seed * static_cast<std::uint64_t>(SceneKind::kCount) +
                static_cast<std::uint64_t>(kind));
  const std::size_t count =
      seed < 3 ? seed : std::uniform_int_distribution<std::size_t>(0, 300)(random);
  RandomScene scene;
  scene.voxel_m = kind == SceneKind::kOnBorders ? 0.03125F : decades(random, 0.005F, 0.2F);
  const float spread_m = kind == SceneKind::kWide ? 1000.0F * scene.voxel_m : 0.5F;
  for (std::size_t i = 0; i < count; ++i)
    scene.spheres.push_back(random_sphere(kind, random, scene.voxel_m, spread_m));
  if (kind == SceneKind::kWide)  // neighbours, or nothing would ever touch
    for (std::size_t i = 1; i < count; i += 2) {
      scene.spheres[i] = scene.spheres[i - 1];
      scene.spheres[i].newest[0].position_m[0] += uniform(random, 0.0F, 0.2F);
    }
  return scene;
}

StillGrid grid_of(const RandomScene& scene) {
  StillGrid grid(0, scene.spheres.size());
  std::copy(scene.spheres.begin(), scene.spheres.end(), grid.records().begin());
  grid.fill(scene.spheres.size(), scene.voxel_m);
  return grid;
}

proto::SphereRecord still_sphere(const std::array<float, 3>& position_m, float radius_m) {
  proto::SphereRecord sphere{};
  const proto::SphereImage image{position_m, {0.0F, 0.0F, 0.0F}};
  sphere.newest = {image, image};
  sphere.older = {image, image};
  sphere.radius_m = radius_m;
  return sphere;
}

const std::array<float, 3>& position_of(const proto::SphereRecord& sphere, std::size_t image) {
  return image < 2 ? sphere.newest[image].position_m : sphere.older[image - 2].position_m;
}

bool overlap(const proto::SphereRecord& a, const proto::SphereRecord& b, std::size_t image) {
  double distance_squared_m2 = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double apart_m =
        double{position_of(a, image)[axis]} - double{position_of(b, image)[axis]};
    distance_squared_m2 += apart_m * apart_m;
  }
  const double reach_m = double{a.radius_m} + double{b.radius_m};
  return distance_squared_m2 < reach_m * reach_m;
}

bool meet(const Box& a, const Box& b) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (a.low_m[axis] > b.high_m[axis] || b.low_m[axis] > a.high_m[axis]) return false;
  return true;
}

}  // namespace stillgrid
