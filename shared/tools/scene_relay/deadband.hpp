#pragma once

#include <cstdint>

#include "proto/tool_segment.hpp"

namespace stillgrid::scene_relay {

/// A change of speed by less than this share of it is not noticed: Weber's law, as the deadband of
/// the kinesthetic codec of IEEE 1918.1.1 uses it.
inline constexpr double kJustNoticeableShare = 0.07;

/// By how much a tool may differ from what the samples sent before say of it.
struct DeadbandLimits {
  double velocity_share = kJustNoticeableShare;  // of the last sent velocity, or of slow_m_s
  double slow_m_s = 0.02;                        // below, the share is of this: estimates are noise
  double distance_m = 1e-4;               // from where the last sent sample leads at its velocity
  double angle_rad = 4e-3;                // from its orientation, which stays
  std::uint64_t silence_ns = 25'000'000;  // after so long a sample is sent however it is
};

/// A sample is led on for so long, then the tool stands: where the one that silence ends was lost
/// as well, another is due.
inline constexpr std::uint64_t kLongestLead_ns = 50'000'000;

/// Where a tool is so long after a sample, had it gone on at its velocity; its orientation stays.
/// Realtime: yes.
[[nodiscard]] proto::ToolState led_on(const proto::ToolState& sample, std::uint64_t by_ns) noexcept;

/// Which samples of a tool need not be sent, for the receiver leads the last one on, led_on(), and
/// is not noticeably wrong: a perceptual deadband on the velocity, as a kinesthetic codec has it,
/// and a bound on the pose, for it is the pose that the simulation pushes bodies with.
///
/// After every sample, sent or not, the tool is within the limits of what was sent last, led on;
/// buttons are never kept back. A lost packet breaks that until the next one, silence_ns later at
/// most. [Hinterseer et al., IEEE Trans. Signal Processing 56(2), 2008; IEEE 1918.1.1.]
/// Thread: one. Realtime: yes.
class Deadband {
 public:
  explicit Deadband(const DeadbandLimits& limits = {}) : limits_(limits) {}

  /// Whether this sample must be sent; if so it is the last sent. The first must, and one that is
  /// no later than the last sent. Pre: numbers, a unit quaternion.
  [[nodiscard]] bool must_send(const proto::ToolState& sample) noexcept;

  /// The next sample must be sent: another receiver has come.
  void begin_anew() noexcept { has_sent_ = false; }

 private:
  [[nodiscard]] bool differs(const proto::ToolState& sample) const noexcept;

  DeadbandLimits limits_;
  proto::ToolState sent_{};
  bool has_sent_ = false;
};

}  // namespace stillgrid::scene_relay
