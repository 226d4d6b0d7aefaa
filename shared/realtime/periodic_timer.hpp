#pragma once

#include <atomic>
#include <cmath>
#include <cstdint>

namespace stillgrid::realtime {

/// CLOCK_MONOTONIC in ns. Realtime: yes.
[[nodiscard]] std::uint64_t monotonic_ns() noexcept;

/// A time or period in whole ns, rounded. Pre: finite, not negative, below 2^63 ns.
[[nodiscard]] inline std::uint64_t to_ns(double seconds) noexcept {
  return static_cast<std::uint64_t>(std::llround(seconds * 1e9));
}

/// Wakes a loop at whole multiples of its period on the monotonic clock, or phase_ns after.
/// Lateness never adds up, and all loops of a machine share one grid of moments. After a stall the
/// loop goes on at the next deadline and never bursts.
class PeriodicTimer {
 public:
  /// Pre: phase_ns < period_ns, or the clock has passed it.
  explicit PeriodicTimer(std::uint64_t period_ns, std::uint64_t phase_ns = 0) noexcept;

  struct Wake {
    std::uint64_t deadline_ns;
    std::uint64_t now_ns;
    std::uint64_t skipped;  // deadlines that passed during a stall
  };

  /// Sleeps to the next deadline, or until *stop, which is looked at every 100 ms.
  /// Realtime: one sleeping system call for periods up to 100 ms.
  Wake wait(const std::atomic<bool>* stop = nullptr) noexcept;

 private:
  std::uint64_t period_ns_;
  std::uint64_t next_ns_;
};

}  // namespace stillgrid::realtime
