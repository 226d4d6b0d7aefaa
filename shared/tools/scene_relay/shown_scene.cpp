#include "shared/tools/scene_relay/shown_scene.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <span>
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
                                [](const auto& field) { return field.body.moving != 0; })),
              .state_capacity = message.state_capacity},
      moving_(message.moving_capacity),
      fields_(limits_.moving_fields),
      hand_(session, std::move(lock), fixed,
            spec_of(session, message, readers, now_ns, round_trip_ns)) {
  hand_.tool().start();
}

void ShownScene::place_spheres(const ToldSnapshot& snapshot) {
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
  moving_.place(positions_m_.data(), velocities_m_s_.data(), period_s_);
}

void ShownScene::place_fields(const ToldSnapshot& snapshot) {
  const bool is_first = hand_.writer().snapshot_id() == 0;
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    const proto::FieldState state = state_of(snapshot.fields[i]);
    if (is_first)
      collision::fill_history(fields_[i], state);
    else
      collision::push_snapshot(fields_[i], state);
  }
}

void ShownScene::show(const ToldSnapshot& snapshot, const publication::SnapshotTimes& times) {
  hand_.writer().segment().require_whole();
  place_spheres(snapshot);
  place_fields(snapshot);
  hand_.writer().publish(moving_.grid(), times, fields_,
                         {.bytes = std::as_bytes(std::span(snapshot.state)),
                          .tick = snapshot.state_tick,
                          .hash = snapshot.state_hash});
}

}  // namespace stillgrid::scene_relay
