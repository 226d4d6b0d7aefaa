#pragma once

#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "shared/collision/grid_query.hpp"
#include "shared/publication/snapshot_reader.hpp"
#include "shared/tools/scene_relay/shown_scene.hpp"
#include "shared/tools/scene_relay/told_scene.hpp"
#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::scene_relay {

inline publication::SceneView view_of(const std::string& session) {
  return publication::SceneView(publication::SegmentReader::require(
      session, proto::SegmentKind::kScene, proto::kSceneLayoutHash));
}

/// Returns the first byte by which the fixed parts of two segments differ, or their size. Each
/// reader normalises the device's orientation, which is left out.
inline std::size_t first_difference(const publication::SceneView& a,
                                    const publication::SceneView& b) {
  if (a.reader().fixed_bytes() != b.reader().fixed_bytes()) return 0;
  const std::size_t turn =
      sizeof(proto::SegmentHeader) + offsetof(proto::SceneHeader, device.orientation_xyzw);
  for (std::size_t i = sizeof(proto::SegmentHeader); i < a.reader().fixed_bytes(); ++i) {
    const bool is_turn = i >= turn && i < turn + sizeof(proto::DeviceFrame::orientation_xyzw);
    if (!is_turn && a.reader().bytes()[i] != b.reader().bytes()[i]) return i;
  }
  return a.reader().fixed_bytes();
}

/// A scene as it is shown on the hand's machine, in a session of its own.
class RelayedScene {
 public:
  explicit RelayedScene(const SceneMessage& message, std::uint64_t round_trip_ns = 0)
      : shown_(session_.name(),
               publication::SessionLock(session_.name(), proto::SegmentKind::kScene), message,
               std::nullopt, 90'001, round_trip_ns),
        view_(view_of(session_.name())) {}

  [[nodiscard]] ShownScene& shown() noexcept { return shown_; }
  [[nodiscard]] const publication::SceneView& view() const noexcept { return view_; }

 private:
  publication::TestSession session_;
  ShownScene shown_;
  publication::SceneView view_;
};

/// Holds the newest snapshot of a scene as a reader finds it.
struct SeenSnapshot {
  proto::SnapshotHeader header{};
  std::vector<proto::SphereRecord> records;
  std::vector<proto::SweptBound> bounds;  // by sphere
  std::vector<proto::FieldRecord> fields;
  std::vector<std::byte> state;
};

inline SeenSnapshot seen(const publication::SceneView& view) {
  publication::SnapshotReader reader;
  reader.turn_to(view);
  SeenSnapshot result;
  const auto look = reader.look(view, [&](const auto& header, const collision::GridView& grid) {
    result = {};
    result.header = header;
    result.bounds.resize(grid.shape.sphere_count);
    for (std::uint32_t i = 0; i < grid.shape.sphere_count; ++i) {
      result.records.push_back(collision::load_record(grid, i));
      result.bounds.at(collision::load_number(grid, i)) = collision::load_bound(grid, i);
    }
    view.copy_state(grid.words, header, result.state);
    for (std::uint32_t i = 0; i < grid.field_count; ++i)
      result.fields.push_back(collision::load_field(grid, i + 1));
  });
  if (!look.accepted()) throw publication::SegmentError("no snapshot");
  return result;
}

/// A snapshot's own span of bytes, to compare.
template <class T>
std::span<const std::byte> bytes_of(const T& value) {
  return std::as_bytes(std::span(&value, 1));
}
template <class T>
bool are_same_bytes(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

}  // namespace stillgrid::scene_relay
