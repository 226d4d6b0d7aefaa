#pragma once

#include <sys/types.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "shared/publication/tool_segment.hpp"
#include "shared/tools/scene_relay/clock_offset.hpp"
#include "shared/tools/scene_relay/messages.hpp"

namespace stillgrid::scene_relay {

/// The tool of the other machine as this one's: a segment as a haptic_server would write it, for as
/// long as its samples come.
///
/// A tick of its path has the hand's number plus a whole number of ticks, the same for all of the
/// segment. So both sides number alike, however the clocks drift. The tick that comes fastest has
/// the number of the millisecond in which it comes. Another segment begins once the clocks have
/// drifted by kLongestDrift ticks. Thread: one.
class ShownTool {
 public:
  ShownTool(std::string session, std::optional<gid_t> readers);

  /// In ticks. A simulation waits no longer than 100 for a tool's next tick.
  static constexpr std::int64_t kLongestDrift = 50;

  /// What became of a sample.
  enum class Shown {
    kShown,
    kRefused,  // a number out of range
    kTaken,    // another program writes this tool here
    kWaits,    // for the next: of another haptic_server, or a flipped bit
  };
  /// Publishes it by its stamp on this machine's clock. Throws SegmentError where memory is short.
  /// Pre: clock.is_known(), and the sample is newer than those before.
  [[nodiscard]] Shown show(const ToolMessage& message, const ClockOffset& clock,
                           std::uint64_t now_ns);

  /// Leads a sample on whose successors the hand keeps back, and ends the segment of a tool that
  /// has fallen silent for longer than `patience_ns`. Called often.
  void look(std::uint64_t now_ns, std::uint64_t patience_ns);
  void withdraw() noexcept { writer_.reset(); }

  /// The stamp of the sample that has this one here, as the hand knows it, to the bit: a simulation
  /// tells which its state contains. 0 where it is none of the last seconds', or was led on.
  [[nodiscard]] std::uint64_t on_hands_clock(std::uint64_t here_ns) const noexcept;
  /// Returns the number on the hand's path of a number on the path here, once there is a sample.
  [[nodiscard]] std::optional<std::uint64_t> hands_number(std::uint64_t number) const noexcept;

  /// Null while it is away.
  [[nodiscard]] proto::SegmentHeader* header() noexcept;
  /// Of the last sample: on this machine's clock, and on the hand's.
  [[nodiscard]] std::uint64_t time_ns() const noexcept { return time_ns_; }
  [[nodiscard]] std::uint64_t newest_ns() const noexcept { return newest_ns_; }
  [[nodiscard]] std::uint64_t segments() const noexcept { return segments_; }

 private:
  [[nodiscard]] Shown open(const ToolMessage& message, const ClockOffset& clock,
                           std::uint64_t now_ns);
  [[nodiscard]] std::uint64_t number_here(std::uint64_t hands) const noexcept;
  void add_to_path(const ToolMessage& message) noexcept;
  void lead_on(std::uint64_t now_ns);

  struct Stamp {
    std::uint64_t here_ns = 0, hands_ns = 0;
  };
  std::string session_;
  std::optional<gid_t> readers_;
  std::optional<publication::ToolWriter> writer_;
  std::optional<proto::ToolState> sample_;  // to be led on
  std::array<Stamp, 4096> stamps_{};
  std::size_t next_stamp_ = 0;
  std::uint64_t epoch_ = 0, next_epoch_ = 0, segments_ = 0;
  std::int64_t shift_ = 0;  // number here less the hand's
  std::uint64_t time_ns_ = 0, newest_ns_ = 0;
  std::uint64_t heard_ns_ = 0, led_ns_ = 0, next_try_ns_ = 0;
};

}  // namespace stillgrid::scene_relay
