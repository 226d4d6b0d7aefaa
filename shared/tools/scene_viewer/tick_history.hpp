#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace stillgrid::scene_viewer {

/// A tick of the haptic loop as it was seen. Scene frame, SI units. Force and all that follows are
/// of the tick before, which is when they came about.
struct TickSample {
  std::uint64_t tick = 0;
  double time_s = 0.0;  // on the frames' axis
  std::array<double, 3> position_m{};
  std::array<double, 3> force_N{};
  double age_s = 0.0;
  double work_us = 0.0;
  double wake_us = 0.0;
  std::uint32_t flags = 0;  // proto::SafetyFlag
  std::uint32_t contacts = 0;
  std::uint64_t snapshot_id = 0;
  std::uint64_t missed = 0;  // since the loop began
};
static_assert(std::is_trivially_copyable_v<TickSample> && sizeof(TickSample) == 112);

/// Microseconds that a share of the ticks does not exceed.
struct TickPercentiles {
  double p50 = 0.0, p99 = 0.0, p999 = 0.0;
};

/// The ticks of the last second.
struct TickSummary {
  std::uint64_t seen = 0;
  std::uint64_t expected = 0;  // by their numbers
  double per_s = 0.0;
  std::uint64_t missed = 0;  // deadlines that passed without a tick, since the loop began
  TickPercentiles work_us, wake_us;
};

/// Of samples in the order of their ticks, those of the second that ends with the last.
[[nodiscard]] TickSummary summary_of(std::span<const TickSample> samples);

/// The answer of /api/ticks: docs/viewer.md.
[[nodiscard]] std::string tick_message(std::span<const TickSample> samples);

/// At most `most` of samples in the order of their ticks, from number `from` on.
[[nodiscard]] std::span<const TickSample> ticks_from(std::span<const TickSample> samples,
                                                     std::uint64_t from, std::size_t most);

/// The ticks of the last minute, 120000 at most. Thread: any.
class TickHistory {
 public:
  /// One more. Pre: its number is higher than the last.
  void add(const TickSample& sample);

  /// At most `most` from number `from` on.
  [[nodiscard]] std::vector<TickSample> from(std::uint64_t from, std::size_t most) const;

  [[nodiscard]] TickSummary summary() const;

 private:
  mutable std::mutex mutex_;
  std::vector<TickSample> samples_;  // and some older ones
};

}  // namespace stillgrid::scene_viewer
