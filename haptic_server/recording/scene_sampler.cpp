#include "haptic_server/recording/scene_sampler.hpp"

#include <algorithm>
#include <cmath>

#include "shared/collision/grid_query.hpp"

namespace stillgrid::recording {
namespace {

SampledSpheres spheres_of(const collision::GridView& grid) {
  const std::uint32_t count = grid.shape.sphere_count;
  const auto stride = static_cast<std::uint32_t>(std::max<std::size_t>(
      1, (count + SceneSampler::kMaxSpheres - 1) / SceneSampler::kMaxSpheres));
  SampledSpheres sampled;
  sampled.spheres.reserve(count / stride + 1);
  for (std::uint32_t i = 0; i < count; i += stride) {
    const proto::SphereRecord record = collision::load_record(grid, i);
    const std::array<float, 3>& at_m = record.newest.position_m;
    if (std::isfinite(at_m[0]) && std::isfinite(at_m[1]) && std::isfinite(at_m[2]) &&
        std::isfinite(record.radius_m))
      sampled.spheres.push_back({at_m, record.radius_m, record.body});
  }
  sampled.left_out = count - sampled.spheres.size();
  return sampled;
}

FixedScene fixed_of(const publication::SceneView& view) {
  const proto::SceneHeader& scene = view.scene();
  FixedScene fixed;
  fixed.spheres = spheres_of(view.static_grid());
  fixed.planes.assign(scene.planes.begin(), scene.planes.begin() + scene.plane_count);
  fixed.tool.assign(scene.tool.begin(), scene.tool.begin() + scene.tool_sphere_count);
  return fixed;
}

}  // namespace

std::optional<SceneSample> SceneSampler::sample(const publication::SceneView& scene) {
  if (reader_.turn_to(scene)) {
    is_first_ = true;
    due_ns_ = 0;
  }
  SceneSample sample;
  bool is_due = false;
  const auto gather = [&](const proto::SnapshotHeader& latest, const collision::GridView& moving) {
    sample.time_ns = latest.publish_time_ns[0];
    is_due = latest.snapshot_id != reader_.snapshot().snapshot_id && sample.time_ns >= due_ns_;
    if (is_due) sample.moving = spheres_of(moving);
  };
  if (!reader_.look(scene, gather).accepted() || !is_due) return std::nullopt;
  if (!is_first_ && sample.moving.spheres == last_) return std::nullopt;
  last_ = sample.moving.spheres;
  due_ns_ = sample.time_ns + last_.size() * 1'000'000'000 / kMaxSpheresPerSecond;
  if (is_first_) sample.fixed = fixed_of(scene);
  is_first_ = false;
  return sample;
}

}  // namespace stillgrid::recording
