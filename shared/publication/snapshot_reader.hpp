#pragma once

#include <cstdint>

#include "shared/publication/scene_segment.hpp"

namespace stillgrid::publication {

/// What a look at the latest snapshot came to.
struct SnapshotLook {
  double_buffer::ReadStatus status = double_buffer::ReadStatus::kEmpty;
  bool is_new = false;    // the first look that accepted this snapshot
  bool is_first = false;  // and nothing of this segment was accepted before it

  [[nodiscard]] bool accepted() const noexcept {
    return status == double_buffer::ReadStatus::kAccepted;
  }
};

/// Follows the snapshots of a scene, whoever writes them: the one place that decides what counts
/// when the segment is another, when a read was overtaken, and when the memory was lost.
///
/// Thread: one. Realtime: wait-free, allocates nothing.
class SnapshotReader {
 public:
  /// Turns to the segment behind `scene`; whether it is another, so that nothing read before
  /// counts.
  bool turn_to(const SceneView& scene) noexcept {
    if (epoch_ == scene.header().epoch) return false;
    epoch_ = scene.header().epoch;
    snapshot_ = {};
    return true;
  }

  /// Looks at the latest snapshot; unless accepted, the last one stands. Empty after a snapshot:
  /// its memory was lost. A snapshot whose header does not bear the number that it was published
  /// under, or an earlier one than the last of this segment, counts as contended: its writer lies.
  ///
  /// gather(header, grid) reads what it needs of the moving spheres, as of read_latest(): it may be
  /// called twice or not at all, and what it read counts once the look was accepted.
  /// Pre: turn_to(scene).
  template <class Gather>
  SnapshotLook look(const SceneView& scene, Gather&& gather) {
    proto::SnapshotHeader latest{};
    const double_buffer::ReadResult read =
        double_buffer::read_latest(scene.buffer(), [&](const std::uint64_t* payload) {
          latest = load_snapshot(payload);
          gather(latest, scene.moving_grid(payload, latest));
        });
    SnapshotLook look{.status = read.status};
    if (!look.accepted()) return look;
    if (latest.snapshot_id != read.snapshot_id || latest.snapshot_id < snapshot_.snapshot_id)
      return {.status = double_buffer::ReadStatus::kContended};
    look.is_new = latest.snapshot_id != snapshot_.snapshot_id;
    look.is_first = look.is_new && !has_snapshot();
    snapshot_ = latest;
    return look;
  }

  /// Of the last accepted snapshot; while gather() runs, of the one before.
  [[nodiscard]] const proto::SnapshotHeader& snapshot() const noexcept { return snapshot_; }
  [[nodiscard]] bool has_snapshot() const noexcept { return snapshot_.snapshot_id != 0; }
  [[nodiscard]] std::uint64_t epoch() const noexcept { return epoch_; }

 private:
  std::uint64_t epoch_ = 0;
  proto::SnapshotHeader snapshot_{};
};

}  // namespace stillgrid::publication
