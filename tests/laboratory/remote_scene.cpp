#include "tests/laboratory/remote_scene.hpp"

#include <unistd.h>

#include <algorithm>
#include <atomic>

#include "shared/collision/field_history.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "sim_server/published_scene.hpp"

namespace stillgrid::laboratory {
namespace {

/// Twice a probe's own size is searched fastest.
constexpr float kVoxelRatio = 2.0F;

std::string unique_session() {
  static std::atomic<int> count = 0;
  return "remote-" + std::to_string(::getpid()) + "-" + std::to_string(++count);
}

template <class T>
std::vector<T> copy_of(std::span<const T> values) {
  return {values.begin(), values.end()};
}

}  // namespace

SentSnapshot sent_snapshot(const dynamics::Simulation& simulation,
                           const publication::SnapshotTimes& times) {
  return {.times = times,
          .spheres = copy_of(simulation.snapshot().records()),
          .fields = copy_of(simulation.field_records())};
}

RemoteScene::RemoteScene(const scene::SceneDescription& scene,
                         const dynamics::Simulation& simulation, double period_s)
    : session_(unique_session()),
      grid_(sizeof(proto::SnapshotHeader), simulation.world().spheres.size()),
      states_(grid_.records().size()),
      writer_(session_, sim_server::static_scene(scene, simulation), grid_.records().size(),
              realtime::to_ns(period_s), proto::Clock::kVirtual, 0) {
  std::ranges::copy(simulation.snapshot().records(), grid_.records().begin());
}

publication::SceneView RemoteScene::view() const {
  return publication::SceneView(publication::SegmentReader::require(
      session_, proto::SegmentKind::kScene, proto::kSceneLayoutHash));
}

void RemoteScene::show(const SentSnapshot& snapshot, std::uint64_t arrival_ns) {
  for (std::size_t i = 0; i < states_.size(); ++i) states_[i] = snapshot.spheres[i].newest;
  grid_.push_snapshot(states_);
  grid_.enter(collision::history_bounds(grid_.records()), kVoxelRatio);
  show_fields(snapshot.fields);
  publication::SnapshotTimes times = snapshot.times;
  times.publish_ns = arrival_ns;
  writer_.publish(grid_, times, fields_);
}

void RemoteScene::show_fields(const std::vector<proto::FieldRecord>& sent) {
  const bool is_first = fields_.empty();
  fields_.resize(sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i) {
    if (is_first)
      collision::fill_history(fields_[i], sent[i].history[0]);
    else
      collision::push_snapshot(fields_[i], sent[i].history[0]);
  }
}

}  // namespace stillgrid::laboratory
