#pragma once

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>

namespace stillgrid::dynamics {

[[nodiscard]] inline std::chrono::nanoseconds to_duration(double time_s) {
  return std::chrono::nanoseconds(std::llround(1e9 * time_s));
}

/// The clock of the calling thread's processor time, which every thread of the process may ask.
[[nodiscard]] inline clockid_t clock_of_this_thread() {
  clockid_t clock = CLOCK_THREAD_CPUTIME_ID;
  pthread_getcpuclockid(pthread_self(), &clock);
  return clock;
}

/// Limits the iterations and the time of a step. The time is the processor time of the thread that
/// makes the budget. Other programs make a step late; they never cut it short. A lockstep budget
/// has no deadline, so that only counts decide.
struct Budget {
  using Nanoseconds = std::chrono::nanoseconds;

  int iterations = std::numeric_limits<int>::max();  // nonlinear solvers share them over a step
  const std::atomic<bool>* stop = nullptr;           // true: the step ends at once
  Nanoseconds deadline = Nanoseconds::max();         // a time of the clock
  clockid_t clock = clock_of_this_thread();
  Nanoseconds earliest = Nanoseconds::max();  // CLOCK_MONOTONIC: before it no step is late

  [[nodiscard]] static Nanoseconds now_of(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return std::chrono::seconds(now.tv_sec) + Nanoseconds(now.tv_nsec);
  }
  [[nodiscard]] Nanoseconds now() const { return now_of(clock); }
  [[nodiscard]] bool has_deadline() const { return deadline != Nanoseconds::max(); }
  /// Ends so much later than now, if not earlier.
  void end_within(Nanoseconds time) {
    deadline = std::min(deadline, now() + time);
    earliest = std::min(earliest, now_of(CLOCK_MONOTONIC) + time);
  }
  [[nodiscard]] bool is_stopped() const { return stop != nullptr && *stop; }
  /// Asks no clock without a deadline. The thread's clock takes a system call: it is asked last.
  [[nodiscard]] bool is_late() const {
    return is_stopped() ||
           (has_deadline() && now_of(CLOCK_MONOTONIC) >= earliest && now() >= deadline);
  }
  [[nodiscard]] bool spent() const { return iterations <= 0 || is_late(); }
};

}  // namespace stillgrid::dynamics
