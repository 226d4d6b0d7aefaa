#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace stillgrid::safety {

/// What the process that holds a device lets its guardian know, in memory that both share.
///
/// Thread: any. Realtime: yes.
struct GuardedState {
  static constexpr int kRuns = -1;

  std::atomic<bool> has_motors = false;  // from before activate() until a deactivate() that did it
  std::atomic<std::uint64_t> beats =
      0;  // grows while its watchdog lives; asked of with motors only
  std::atomic<bool> is_crashing = false;  // in its last emergency_stop, which may hang
  std::atomic<bool> is_released = false;  // by one of the ways of GuardedProgram
  std::atomic<int> end_status = kRuns;    // what it is about to end with, of its own will
  std::atomic<bool> stop = false;         // set by SIGINT, SIGTERM and SIGHUP to either process
  pid_t guardian = 0;
};

/// Counts a beat of the child's watchdog, and sets `stop` if the guardian is gone: a driver may
/// have replaced the handler of the kernel's SIGTERM. Thread: any. Realtime: one system call.
void beat(GuardedState& state) noexcept;

/// A program in two processes: work, which holds the device and runs foreign code, and its
/// guardian, which runs none and outlives it.
struct GuardedProgram {
  std::string subject;                     // of its lines: "device 'phantom'"
  std::function<int(GuardedState&)> work;  // returns the exit status, throws nothing
  /// Ways to take the force off motors that work left on, without anything of its process; each
  /// runs in a process of its own and says by returning that it did. Those that throw, crash, end
  /// their process or take longer than 10 s are followed by the next.
  std::vector<std::function<void()>> releases;
};

/// Runs work in a child process until it ends, and releases the motors where that ended with them
/// on: by exit(), a crash or a signal; also where its watchdog has not lived for 2 s, when the
/// child is killed. A debugger that holds the child may take its time. One line on standard error
/// says what happened.
///
/// Returns work's status; kDeviceFault where that was 0 with motors on, where the child ended
/// otherwise than by returning, and where it was killed here; 128 + n where signal n ended it.
/// SIGINT, SIGTERM and SIGHUP set GuardedState::stop here, whatever handlers a driver installs in
/// the child. Every signal that ends a program is also passed on to the child, which gets SIGTERM
/// when the guardian itself dies. Processes that a driver leaves behind, its orphans included, are
/// killed before the motors are released. Before any thread. The child does not come back from this
/// call.
///
/// Throws std::system_error if there is no process to be had.
[[nodiscard]] int run_guarded(const GuardedProgram& program);

}  // namespace stillgrid::safety
