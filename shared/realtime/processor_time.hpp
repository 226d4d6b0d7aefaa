#pragma once

#include <pthread.h>

#include <cstdint>
#include <ctime>

namespace stillgrid::realtime {

/// The clock of the calling thread's processor time, which every thread of the process may ask.
[[nodiscard]] inline clockid_t clock_of_this_thread() noexcept {
  clockid_t clock = CLOCK_THREAD_CPUTIME_ID;
  ::pthread_getcpuclockid(::pthread_self(), &clock);
  return clock;
}

/// Returns the processor time of the thread of that clock, ns. Realtime: one system call.
[[nodiscard]] inline std::uint64_t processor_ns(clockid_t clock) noexcept {
  timespec now{};
  ::clock_gettime(clock, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000 +
         static_cast<std::uint64_t>(now.tv_nsec);
}

/// Processor time of the calling thread, s: what else the machine does is left out.
[[nodiscard]] inline double thread_processor_s() noexcept {
  return 1e-9 * static_cast<double>(processor_ns(CLOCK_THREAD_CPUTIME_ID));
}

}  // namespace stillgrid::realtime
