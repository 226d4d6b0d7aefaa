#pragma once

#include <atomic>
#include <stdexcept>

namespace stillgrid::realtime {

/// True once SIGINT, SIGTERM or SIGHUP came. install_stop_signal() once per process, before
/// threads.
[[nodiscard]] const std::atomic<bool>& stop_requested() noexcept;
void install_stop_signal();

/// Makes stop signals set `shared`, and stop_requested() read it: memory shared with a guardian,
/// which may set it too. Pre: before install_stop_signal().
void share_stop(std::atomic<bool>& shared) noexcept;

/// The same for every other signal that ends a program and may be heeded, as SIGQUIT, SIGALRM or
/// SIGXCPU, where nobody has seen to it yet. Once per process, before threads.
void install_rare_stop_signals();

/// Which of those rare ones came first; 0 when none did.
[[nodiscard]] int rare_stop_signal() noexcept;

/// Work that takes long, as reading a mesh, was given up because a stop was requested.
struct StopRequested : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws StopRequested once stop_requested(): called often in work that takes long and runs in no
/// loop of time. A load and a branch.
inline void throw_if_stopped() {
  if (stop_requested().load(std::memory_order_relaxed)) throw StopRequested("stopped by a signal");
}

}  // namespace stillgrid::realtime
