#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "proto/tool_segment.hpp"
#include "shared/reading/segment_follower.hpp"
#include "shared/tools/scene_viewer/frame.hpp"
#include "shared/tools/scene_viewer/tick_history.hpp"

namespace stillgrid::scene_viewer {

/// What is known of a session's haptic loop.
struct ToolLook {
  reading::Life hand = reading::Life::kAbsent;
  std::optional<proto::RelayFigures> relay;  // that writes the tool's segment
  std::string refusal;
  std::optional<proto::ToolState> state;  // checked; its tick numbered on
  proto::Clock clock = proto::Clock::kMonotonic;
  std::uint64_t period_ns = 0;  // 0: none came yet
  std::uint64_t epoch = 0;
  std::uint32_t writer_pid = 0;
};

/// Looks at a session's tool somewhat faster than 1 kHz and keeps the ticks. What it misses the
/// numbers tell. Ticks are numbered on from one haptic loop to the next. Thread: its own; its
/// calls: any.
class ToolSampler {
 public:
  ToolSampler(const std::string& session, TimeAxis real_axis);

  [[nodiscard]] ToolLook look() const;
  [[nodiscard]] const TickHistory& history() const noexcept { return history_; }

 private:
  void run(const std::stop_token& stop);
  void follow();
  void sample();

  reading::SegmentFollower follower_;  // of the thread
  TimeAxis real_axis_;
  std::uint64_t epoch_ = 0;   // of the loop seen last
  std::uint64_t before_ = 0;  // ticks of the loops before it
  std::uint64_t last_ = 0;    // tick seen last, numbered on
  TickHistory history_;
  mutable std::mutex mutex_;
  ToolLook look_;
  std::jthread thread_;  // last: joined before what it uses is gone
};

/// The axis of a session's times: in real time the one given, in virtual time its own.
[[nodiscard]] inline TimeAxis axis_of(proto::Clock clock, TimeAxis real_axis) noexcept {
  return clock == proto::Clock::kVirtual ? TimeAxis{} : real_axis;
}

}  // namespace stillgrid::scene_viewer
