#pragma once

namespace stillgrid::realtime {

/// From now on each system call of the calling thread, and of the threads and processes that it
/// starts, is noted by its name and then made. Not trapped are the clock, an absolute sleep on
/// CLOCK_MONOTONIC, the return from a signal, pages put in place of a lost mapping, and the start
/// of a thread. For the rest of the thread's life; each call costs a signal.
///
/// 0, or the errno of what could not be had. x86-64 only.
[[nodiscard]] int filter_system_calls() noexcept;

}  // namespace stillgrid::realtime
