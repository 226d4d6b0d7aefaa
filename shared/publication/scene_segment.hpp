#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/scene_segment.hpp"
#include "shared/collision/touch_lists.hpp"
#include "shared/collision/voxel_grid.hpp"
#include "shared/publication/published_fields.hpp"
#include "shared/publication/segment.hpp"

namespace stillgrid::publication {

/// The constant part of a scene, which a simulation publishes once: static spheres and planes,
/// distance fields, materials, tool, place of the device.
struct StaticScene {
  std::string name;
  std::vector<proto::Material> materials;    // at most kMaxMaterials
  std::vector<proto::Plane> planes;          // at most kMaxPlanes
  std::vector<proto::ToolSphere> tool;       // at most kMaxToolSpheres
  std::vector<proto::SphereRecord> spheres;  // that never move
  std::vector<PublishedField> fields;        // at most kMaxFields
  proto::DeviceFrame device{};
  float tool_slip_speed_m_s = 0.0F;  // see proto::SceneHeader
  float voxel_ratio = 2.0F;      // of the static grid; twice a probe's own size is searched fastest
  std::vector<std::byte> model;  // steps the scene elsewhere; empty: snapshots have no state
  std::size_t state_capacity = 0;  // bytes of the largest state of a snapshot
  std::vector<std::string> hands;  // names of all hands of the session, at most kMaxHands
  std::size_t hand = 0;            // which of them the segment is for
};

/// Returns the largest probe that touch lists serve, m. tool_radius_m: that of the tool's largest
/// sphere. A proxy finds its neighbours, a radius away, and moves by an eighth in a tick.
[[nodiscard]] constexpr float touch_probe_radius_m(float tool_radius_m) noexcept {
  return 2.125F * tool_radius_m;
}
[[nodiscard]] collision::TouchLists touch_lists_of(const StaticScene& scene);

/// The times of one snapshot, on the writer's clock, and what was counted up to it.
struct SnapshotTimes {
  std::uint64_t state_ns = 0;    // simulated
  std::uint64_t publish_ns = 0;  // of the switch, T_n
  std::uint64_t tool_ns = 0;     // of the tool sample it contains, 0: none
  std::uint64_t step_ns = 0;     // cost
  std::uint64_t contacts = 0;
  double tool_work_J = 0.0;  // that the tool has given the scene up to the state
};

/// The state from which another process continues. One that is larger than the slots' capacity is
/// left out.
struct SnapshotState {
  std::span<const std::byte> bytes = {};
  std::uint64_t tick = 0, hash = 0;  // see proto::SnapshotHeader
};

/// The simulation's end of the scene segment.
///
/// Snapshots are made in the simulation's own VoxelGrid and copied whole. Thread: one.
class SceneWriter {
 public:
  /// Announces the segment with no snapshot yet. readers: a group that may read it too. Throws
  /// SegmentError. Pre: the lock is that of a scene segment.
  SceneWriter(SessionLock lock, const StaticScene& scene, std::size_t moving_count,
              std::uint64_t period_ns, proto::Clock clock, std::uint64_t start_ns,
              std::optional<gid_t> readers = std::nullopt)
      : SceneWriter(std::move(lock), scene, touch_lists_of(scene), moving_count, period_ns, clock,
                    start_ns, readers) {}

  /// The same by a lock of its own.
  SceneWriter(std::string_view session, const StaticScene& scene, std::size_t moving_count,
              std::uint64_t period_ns, proto::Clock clock, std::uint64_t start_ns)
      : SceneWriter(SessionLock(session, proto::SegmentKind::kScene), scene, moving_count,
                    period_ns, clock, start_ns) {}

  /// Shows the next snapshot, entered where its spheres may be displayed (bound_history).
  /// fields: one for each of the scene's that moves, in order.
  /// Pre: snapshot has room for sizeof(SnapshotHeader) before moving_count spheres.
  void publish(const collision::VoxelGrid& snapshot, const SnapshotTimes& times,
               std::span<const proto::FieldRecord> fields = {},
               const SnapshotState& state = {}) noexcept;

  [[nodiscard]] proto::SegmentHeader& header() noexcept { return segment_.header(); }
  [[nodiscard]] const SegmentWriter& segment() const noexcept { return segment_; }
  /// Returns the fixed part of the scene, as readers see it.
  [[nodiscard]] const proto::SceneHeader& scene() const noexcept { return fixed_; }
  [[nodiscard]] collision::GridView static_grid() const noexcept { return static_grid_.view(); }
  [[nodiscard]] std::uint64_t snapshot_id() const noexcept { return snapshot_.snapshot_id; }
  /// Whether the last snapshot carries a state. One that is larger than its place is left out.
  [[nodiscard]] bool has_state() const noexcept { return snapshot_.state_bytes > 0; }

 private:
  SceneWriter(SessionLock lock, const StaticScene& scene, const collision::TouchLists& touch_lists,
              std::size_t moving_count, std::uint64_t period_ns, proto::Clock clock,
              std::uint64_t start_ns, std::optional<gid_t> readers);

  collision::GridLayout moving_;
  collision::VoxelGrid static_grid_;
  FieldPlaces fields_;
  std::vector<std::uint64_t> field_records_, state_;  // as a slot holds them
  proto::SceneHeader fixed_;
  proto::SnapshotHeader snapshot_{};
  SegmentWriter segment_;
};

/// Whether counts, materials, planes, tool, hands and place of the device are ones that may be:
/// what every reader asks of a fixed part first.
[[nodiscard]] bool is_sound(const proto::SceneHeader& scene);

/// Copies a slot's SnapshotHeader, of its grid only the levels it counts. Realtime: yes.
[[nodiscard]] proto::SnapshotHeader load_snapshot(const std::uint64_t* payload) noexcept;

/// A reader's end of the scene segment: the fixed part as a checked local copy, the fields and the
/// slots in place.
class SceneView {
 public:
  /// Throws SegmentError unless every count, index and number of the fixed part is sound.
  explicit SceneView(SegmentReader&& reader);

  [[nodiscard]] const proto::SceneHeader& scene() const noexcept { return scene_; }
  [[nodiscard]] const collision::GridView& static_grid() const noexcept { return static_grid_; }
  [[nodiscard]] std::span<const SceneField> fields() const noexcept { return fields_; }
  [[nodiscard]] std::uint32_t moving_fields() const noexcept { return moving_fields_; }
  /// The same spheres as a tick searches them.
  [[nodiscard]] const collision::TouchView& touch_lists() const noexcept { return touch_lists_; }
  [[nodiscard]] const double_buffer::DoubleBuffer& buffer() const noexcept {
    return reader_.buffer();
  }
  [[nodiscard]] const SegmentReader& reader() const noexcept { return reader_; }
  [[nodiscard]] const proto::SegmentHeader& header() const noexcept { return reader_.header(); }

  /// The grid of a slot's payload whose header was loaded, with its fields; without a sphere
  /// where the header lies.
  /// Realtime: yes.
  [[nodiscard]] collision::GridView moving_grid(
      const std::uint64_t* payload, const proto::SnapshotHeader& snapshot) const noexcept;

  /// Returns the bytes of the model; empty where snapshots have no state.
  [[nodiscard]] std::span<const std::byte> model() const noexcept {
    return {reader_.bytes() + scene_.model_offset, scene_.model_bytes};
  }
  /// Copies the state of a slot's payload whose header was loaded. bytes has the state's size then.
  /// A size beyond the slot's capacity counts as 0. Realtime: yes, where bytes
  /// has the capacity.
  void copy_state(const std::uint64_t* payload, const proto::SnapshotHeader& snapshot,
                  std::vector<std::byte>& bytes) const;

 private:
  SegmentReader reader_;
  proto::SceneHeader scene_{};
  collision::GridView static_grid_;
  collision::TouchView touch_lists_;
  collision::GridLayout moving_layout_;
  std::vector<SceneField> fields_;
  std::uint32_t moving_fields_ = 0;
};

}  // namespace stillgrid::publication
