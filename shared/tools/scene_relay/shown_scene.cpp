#include "shared/tools/scene_relay/shown_scene.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "shared/collision/field_history.hpp"
#include "shared/tools/scene_relay/arrays.hpp"
#include "shared/tools/scene_relay/told_scene.hpp"

namespace stillgrid::scene_relay {
namespace {

/// A force fades 1.5 of the periods that a segment declares after its last snapshot
/// (docs/safety.md). Steps faster than this lose two in a row too often for that.
constexpr std::uint64_t kShortestPromise_ns = 33'333'333;

std::uint64_t declared_period_ns(std::uint64_t period_ns, std::uint64_t round_trip_ns) {
  return std::max(period_ns + std::min(period_ns, round_trip_ns), kShortestPromise_ns);
}

publication::SessionSpec spec_of(const std::string& session, const SceneMessage& message,
                                 const std::optional<gid_t>& readers, std::uint64_t now_ns,
                                 std::uint64_t round_trip_ns) {
  return {.name = session,
          .moving_count = message.moving_capacity,
          .period_ns = declared_period_ns(message.period_ns, round_trip_ns),
          .clock = proto::Clock::kMonotonic,
          .start_ns = now_ns,
          .readers = readers,
          .report = [](const std::string& line) { spdlog::warn(line); }};
}

proto::TurningBody turning_of(const stillgrid_relay1_Turning& told) {
  proto::TurningBody body{};
  body.body = told.body;
  body.centre_m = std::to_array(told.centre_m);
  body.velocity_m_s = std::to_array(told.velocity_m_s);
  std::memcpy(body.turns.data(), told.turns, sizeof told.turns);
  return body;
}

}  // namespace

ShownScene::ShownScene(const std::string& session, publication::SessionLock lock,
                       const SceneMessage& message, const std::optional<gid_t>& readers,
                       std::uint64_t now_ns, std::uint64_t round_trip_ns)
    : ShownScene(session, std::move(lock), message, scene_of(message), readers, now_ns,
                 round_trip_ns) {}

ShownScene::ShownScene(const std::string& session, publication::SessionLock lock,
                       const SceneMessage& message, const publication::StaticScene& fixed,
                       const std::optional<gid_t>& readers, std::uint64_t now_ns,
                       std::uint64_t round_trip_ns)
    : epoch_(message.scene_epoch),
      period_s_(1e-9 * static_cast<double>(message.period_ns)),
      limits_{.moving_capacity = message.moving_capacity,
              .material_count = message.materials._length,
              .moving_fields = static_cast<std::uint32_t>(
                  std::count_if(fixed.fields.begin(), fixed.fields.end(),
                                [](const auto& field) { return field.body.moving != 0; }))},
      moving_(message.moving_capacity),
      fields_(limits_.moving_fields),
      hand_(session, std::move(lock), fixed,
            spec_of(session, message, readers, now_ns, round_trip_ns)) {
  hand_.tool().start();
}

void ShownScene::place_spheres(const ToldSnapshot& snapshot, double period_s) {
  const std::size_t count = snapshot.motions.size();
  radii_m_.resize(count);
  materials_.resize(count);
  bodies_.resize(count);
  positions_m_.clear();
  velocities_m_s_.clear();
  for (std::size_t i = 0; i < count; ++i) {
    radii_m_[i] = double{snapshot.labels[i].radius_m};
    materials_[i] = snapshot.labels[i].material;
    bodies_[i] = snapshot.labels[i].body;
    const Motion& motion = snapshot.motions[i];
    positions_m_.insert(positions_m_.end(), motion.position_m, motion.position_m + 3);
    velocities_m_s_.insert(velocities_m_s_.end(), motion.velocity_m_s, motion.velocity_m_s + 3);
  }
  stillgrid_shapes shapes{};
  shapes.count = static_cast<std::uint32_t>(count);
  shapes.radii_m = radii_m_.data();
  shapes.materials = materials_.data();
  shapes.bodies = bodies_.data();
  moving_.declare(shapes);
  moving_.place(positions_m_.data(), velocities_m_s_.data(), period_s);
  for (std::size_t i = 0; i < count; ++i)
    moving_.predict(i, std::to_array(snapshot.motions[i].predicted_velocity_m_s),
                    snapshot.labels[i].response);
  moving_.cover_predictions(period_s);
}

void ShownScene::place_fields(const ToldSnapshot& snapshot) {
  const bool is_first = hand_.writer().snapshot_id() == 0;
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    const FieldMotion& told = snapshot.fields[i];
    proto::FieldRecord& record = fields_[i];
    if (is_first)
      collision::fill_history(record, state_of(told.state));
    else
      collision::push_snapshot(record, state_of(told.state));
    record.predicted_velocity_m_s = std::to_array(told.predicted_velocity_m_s);
    record.predicted_angular_velocity_rad_s = std::to_array(told.predicted_angular_velocity_rad_s);
    record.response = told.response;
  }
}

void ShownScene::show(const ToldSnapshot& snapshot, const publication::SnapshotTimes& times) {
  hand_.writer().segment().require_whole();
  const double prediction_s = 1e-9 * static_cast<double>(snapshot.prediction_ns);
  place_spheres(snapshot, std::max(period_s_, prediction_s));
  place_fields(snapshot);
  std::array<proto::ResponseMode, proto::kMaxModes> modes{};
  std::array<proto::TurningBody, proto::kMaxTurningBodies> turning{};
  std::transform(snapshot.modes.begin(), snapshot.modes.end(), modes.begin(),
                 [](const auto& told) { return std::bit_cast<proto::ResponseMode>(told); });
  std::transform(snapshot.turning.begin(), snapshot.turning.end(), turning.begin(), turning_of);
  hand_.writer().publish(moving_.grid(), times,
                         {.period_ns = snapshot.prediction_ns,
                          .modes = {modes.data(), snapshot.modes.size()},
                          .turning = {turning.data(), snapshot.turning.size()},
                          .responses = snapshot.responses},
                         fields_);
}

}  // namespace stillgrid::scene_relay
