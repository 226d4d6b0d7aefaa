#pragma once

#include <ctime>

namespace stillgrid::realtime {

/// Processor time of the calling thread, s: what else the machine does is left out.
[[nodiscard]] inline double thread_processor_s() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace stillgrid::realtime
