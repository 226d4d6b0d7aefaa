#pragma once

#include <optional>
#include <string_view>

#include "proto/tool_segment.hpp"
#include "shared/publication/segment.hpp"

namespace stillgrid::publication {

/// The haptic server's end: one ToolState a tick.
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

  /// Realtime: wait-free.
  void publish(const proto::ToolState& state) noexcept;

  [[nodiscard]] proto::SegmentHeader& header() noexcept { return segment_.header(); }
  [[nodiscard]] const SegmentWriter& segment() const noexcept { return segment_; }

 private:
  SegmentWriter segment_;
  std::uint64_t count_ = 0;
};

/// Whether place, velocity and force are numbers within kLargestNumber, and the orientation is
/// nearly a unit quaternion: asked before a state is used.
[[nodiscard]] bool is_sound(const proto::ToolState& state) noexcept;

/// Whether the figures of the tick before are numbers within kLargestNumber, and their flags known
/// ones: asked before they are shown. The simulation uses none of them.
[[nodiscard]] bool has_sound_figures(const proto::ToolState& state) noexcept;

/// The simulation's end.
class ToolView {
 public:
  explicit ToolView(SegmentReader&& reader);

  /// The newest state that passed its checks: whole, no number above kLargestNumber, a unit
  /// quaternion. Nothing before the first.
  [[nodiscard]] std::optional<proto::ToolState> read() const noexcept;

  [[nodiscard]] const SegmentReader& reader() const noexcept { return reader_; }
  [[nodiscard]] const proto::SegmentHeader& header() const noexcept { return reader_.header(); }

 private:
  SegmentReader reader_;
};

}  // namespace stillgrid::publication
