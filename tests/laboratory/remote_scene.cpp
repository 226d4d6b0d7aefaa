#include "tests/laboratory/remote_scene.hpp"

#include <unistd.h>

#include <Eigen/Core>
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

Eigen::Vector3d vector(const std::array<float, 3>& v) {
  return Eigen::Map<const Eigen::Vector3f>(v.data()).cast<double>();
}

template <class T>
std::vector<T> copy_of(std::span<const T> values) {
  return {values.begin(), values.end()};
}

}  // namespace

SentSnapshot sent_snapshot(const dynamics::Simulation& simulation,
                           const publication::SnapshotTimes& times,
                           const publication::SnapshotPrediction& prediction) {
  return {.times = times,
          .spheres = copy_of(simulation.snapshot().records()),
          .fields = copy_of(simulation.field_records()),
          .prediction_ns = prediction.period_ns,
          .modes = copy_of(prediction.modes),
          .turning = copy_of(prediction.turning),
          .responses = copy_of(prediction.responses)};
}

RemoteScene::RemoteScene(const scene::SceneDescription& scene,
                         const dynamics::Simulation& simulation, double period_s)
    : session_(unique_session()),
      grid_(sizeof(proto::SnapshotHeader), simulation.world().spheres.size()),
      states_(grid_.records().size()),
      bounds_(grid_.records().size()),
      writer_(session_, sim_server::static_scene(scene, simulation), grid_.records().size(),
              realtime::to_ns(period_s), proto::Clock::kVirtual, 0) {
  std::ranges::copy(simulation.snapshot().records(), grid_.records().begin());
}

publication::SceneView RemoteScene::view() const {
  auto reader = publication::SegmentReader::open(session_, proto::SegmentKind::kScene,
                                                 proto::kSceneLayoutHash);
  if (!reader) throw publication::SegmentError("the session '" + session_ + "' is gone");
  return publication::SceneView(std::move(*reader));
}

void RemoteScene::show(const SentSnapshot& snapshot, std::uint64_t arrival_ns) {
  for (std::size_t i = 0; i < states_.size(); ++i) states_[i] = snapshot.spheres[i].newest;
  grid_.push_snapshot(states_);
  for (std::size_t i = 0; i < states_.size(); ++i) {
    grid_.records()[i].predicted_velocity_m_s = snapshot.spheres[i].predicted_velocity_m_s;
    grid_.records()[i].response = snapshot.spheres[i].response;
  }
  enter(proto::kPredictionPeriods * 1e-9 * static_cast<double>(snapshot.prediction_ns));
  show_fields(snapshot.fields);
  publication::SnapshotTimes times = snapshot.times;
  times.publish_ns = arrival_ns;
  writer_.publish(grid_, times,
                  {.period_ns = snapshot.prediction_ns,
                   .modes = snapshot.modes,
                   .turning = snapshot.turning,
                   .responses = snapshot.responses},
                  fields_);
}

/// Each sphere where it may be displayed: in its history, led on, and from where it led before.
void RemoteScene::enter(double prediction_s) {
  for (std::size_t i = 0; i < bounds_.size(); ++i) {
    const proto::SphereRecord& record = grid_.records()[i];
    bounds_[i] = collision::bound_history(record, prediction_s);
    if (record.response == 0) continue;
    const double behind_m =
        proto::kLongestPredictionLag_s * vector(record.predicted_velocity_m_s).norm();
    bounds_[i].bounding_radius_m += static_cast<float>(behind_m);
  }
  grid_.enter(bounds_, kVoxelRatio);
}

void RemoteScene::show_fields(const std::vector<proto::FieldRecord>& sent) {
  const bool is_first = fields_.empty();
  fields_.resize(sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i) {
    if (is_first)
      collision::fill_history(fields_[i], sent[i].history[0]);
    else
      collision::push_snapshot(fields_[i], sent[i].history[0]);
    fields_[i].predicted_velocity_m_s = sent[i].predicted_velocity_m_s;
    fields_[i].predicted_angular_velocity_rad_s = sent[i].predicted_angular_velocity_rad_s;
    fields_[i].response = sent[i].response;
  }
}

}  // namespace stillgrid::laboratory
