#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>

#include "shared/realtime/periodic_timer.hpp"
#include "shared/realtime/processor_time.hpp"

namespace stillgrid::dynamics {

/// Limits the time of a step. The time is the processor time of the thread that
/// makes the budget. Other programs make a step late; they never cut it short. A lockstep budget
/// has no deadline, so that only counts decide.
struct Budget {
  static constexpr std::uint64_t kNone_ns = std::numeric_limits<std::uint64_t>::max();

  const std::atomic<bool>* stop = nullptr;  // true: the step ends at once
  std::uint64_t deadline_ns = kNone_ns;     // a time of the clock
  clockid_t clock = realtime::clock_of_this_thread();
  std::uint64_t earliest_ns = kNone_ns;  // CLOCK_MONOTONIC: before it no step is late

  [[nodiscard]] std::uint64_t now_ns() const { return realtime::processor_ns(clock); }
  [[nodiscard]] bool has_deadline() const { return deadline_ns != kNone_ns; }
  /// Ends so much later than now, if not earlier.
  void end_within(std::uint64_t time_ns) {
    deadline_ns = std::min(deadline_ns, now_ns() + time_ns);
    earliest_ns = std::min(earliest_ns, realtime::monotonic_ns() + time_ns);
  }
  [[nodiscard]] bool is_stopped() const { return stop != nullptr && *stop; }
  /// Asks no clock without a deadline. The thread's clock takes a system call: it is asked last.
  [[nodiscard]] bool is_late() const {
    return is_stopped() ||
           (has_deadline() && realtime::monotonic_ns() >= earliest_ns && now_ns() >= deadline_ns);
  }
};

}  // namespace stillgrid::dynamics
