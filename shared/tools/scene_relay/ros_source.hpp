#pragma once

#include <cstdint>

#include "shared/publication/tool_segment.hpp"

namespace stillgrid::scene_relay {

/// What became of the ticks that a haptic loop published.
struct RosCounts {
  std::uint64_t taken = 0;
  std::uint64_t spared = 0;   // seen, but sooner than the rate asked for
  std::uint64_t missed = 0;   // came and went between two looks, or were no pose
  std::uint64_t refused = 0;  // figures no numbers; stamped in the future, long ago or backwards
};

/// Which of the tool's states are published: each at most once, at no more than a rate. Thread:
/// one.
class RosSource {
 public:
  /// Pre: rate_hz > 0. Of a loop that is as fast as that or slower, every state is due.
  explicit RosSource(double rate_hz) noexcept;

  /// Whether a state read from the segment with this header is to be published: nobody had it yet,
  /// it is due, every figure of it is sound, and its stamp is of the last kOldest_ns before now_ns,
  /// which was read after it. Pre: the segment is on the monotonic clock. Realtime: yes.
  [[nodiscard]] bool takes(const proto::SegmentHeader& segment, const proto::ToolState& state,
                           std::uint64_t now_ns) noexcept;

  [[nodiscard]] const RosCounts& counts() const noexcept { return counts_; }

  /// What a stopped loop published last is no news.
  static constexpr std::uint64_t kOldest_ns = 250'000'000;

 private:
  [[nodiscard]] bool is_new(std::uint64_t epoch, std::uint64_t tick) noexcept;
  [[nodiscard]] bool is_due(std::uint64_t time_ns, std::uint64_t period_ns) noexcept;

  std::uint64_t interval_ns_;
  std::uint64_t epoch_ = 0;         // of the segment that was looked at last
  std::uint64_t last_tick_ = 0;     // seen in it
  std::uint64_t last_time_ns_ = 0;  // of the state taken last, of any segment
  std::uint64_t next_ns_ = 0;       // when one is due
  RosCounts counts_;
};

}  // namespace stillgrid::scene_relay
