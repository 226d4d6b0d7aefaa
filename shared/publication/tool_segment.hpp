#pragma once

#include <optional>
#include <string_view>

#include "proto/tool_segment.hpp"
#include "shared/publication/segment.hpp"

namespace stillgrid::publication {

/// The haptic server's end: one ToolState a tick, and the path.
class ToolWriter {
 public:
  /// Announces the segment. readers: a group that may read it too. Throws SegmentError. Pre: the
  /// lock is that of a tool segment.
  ToolWriter(SessionLock lock, std::uint64_t period_ns, proto::Clock clock, std::uint64_t start_ns,
             std::optional<gid_t> readers = std::nullopt);

  /// The same by a lock of its own.
  ToolWriter(std::string_view session, std::uint64_t period_ns, proto::Clock clock,
             std::uint64_t start_ns)
      : ToolWriter(SessionLock(session, proto::SegmentKind::kTool), period_ns, clock, start_ns) {}

  /// Adds a tick to the path. Ignores one whose number is not above the newest one's. publish()
  /// adds that of its state: only ticks before it need this. Realtime: wait-free.
  void add_to_path(const proto::PathSample& sample) noexcept;

  /// Publishes the state, and before it the path's sample of its path_number, unless that number is
  /// not above the newest one's. Realtime: wait-free.
  void publish(const proto::ToolState& state) noexcept;

  [[nodiscard]] proto::SegmentHeader& header() noexcept { return segment_.header(); }
  [[nodiscard]] const SegmentWriter& segment() const noexcept { return segment_; }

 private:
  SegmentWriter segment_;
  std::uint64_t count_ = 0;
  std::uint64_t newest_ = proto::kNever;  // number on the path
};

/// Whether place, velocity and force are numbers within kLargestNumber, and the orientation is
/// nearly a unit quaternion: asked before a state is used.
[[nodiscard]] bool is_sound(const proto::ToolState& state) noexcept;

/// Whether place and velocity of a sample are numbers within kLargestNumber, and the orientation is
/// nearly a unit quaternion.
[[nodiscard]] bool is_sound(const proto::PathSample& sample) noexcept;

/// Whether the figures of the tick before are numbers within kLargestNumber, and their flags known
/// ones: asked before they are shown. The simulation uses none of them.
[[nodiscard]] bool has_sound_figures(const proto::ToolState& state) noexcept;

/// The last kPathLength ticks of the tool's path. Lives as long as the view that it is from.
/// Thread: any. Realtime: wait-free.
class PathView {
 public:
  explicit PathView(const proto::ToolPath& path) noexcept : path_(&path) {}

  /// Returns the number of the newest sample, once there is one. A hostile writer may give any.
  [[nodiscard]] std::optional<std::uint64_t> newest() const noexcept;

  /// Returns sample n if it is whole and sound. A sample that is being written or overwritten is
  /// not whole. The squared norm of its quaternion is 1 within 1e-3: the user normalises it.
  [[nodiscard]] std::optional<proto::PathSample> sample(std::uint64_t n) const noexcept;

 private:
  const proto::ToolPath* path_;
};

/// The simulation's end.
class ToolView {
 public:
  /// Throws SegmentError if the segment is too small for a path or for a state.
  explicit ToolView(SegmentReader&& reader);

  /// The newest state that passed its checks: whole, no number above kLargestNumber, a unit
  /// quaternion. Nothing before the first.
  [[nodiscard]] std::optional<proto::ToolState> read() const noexcept;

  [[nodiscard]] PathView path() const noexcept;

  [[nodiscard]] const SegmentReader& reader() const noexcept { return reader_; }
  [[nodiscard]] const proto::SegmentHeader& header() const noexcept { return reader_.header(); }

 private:
  SegmentReader reader_;
};

}  // namespace stillgrid::publication
