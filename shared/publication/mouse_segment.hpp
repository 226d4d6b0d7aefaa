#pragma once

#include <optional>

#include "proto/mouse_segment.hpp"
#include "shared/publication/segment.hpp"

namespace stillgrid::publication {

/// Whether every number is finite, the place within kFarthestMouse_m per axis, and the orientation
/// a unit quaternion within 1e-3: asked before a pose is used.
[[nodiscard]] bool is_sound(const proto::MousePose& pose) noexcept;

/// The viewer's end. Thread: one.
class MouseWriter {
 public:
  /// Announces the segment. Throws SegmentError. Pre: the lock is that of a mouse segment.
  explicit MouseWriter(SessionLock lock);

  /// Publishes a pose. Realtime: wait-free.
  void publish(const proto::MousePose& pose) noexcept;

 private:
  SegmentWriter segment_;
  std::uint64_t count_ = 0;
};

/// The device's end.
class MouseView {
 public:
  /// Throws SegmentError if the segment is too small for a pose.
  explicit MouseView(SegmentReader&& reader);

  /// Returns the newest pose. Returns std::nullopt before the first, and if the pose is torn or
  /// fails is_sound(). Realtime: wait-free.
  [[nodiscard]] std::optional<proto::MousePose> read() const noexcept;

  [[nodiscard]] const SegmentReader& reader() const noexcept { return reader_; }

 private:
  SegmentReader reader_;
};

}  // namespace stillgrid::publication
