#pragma once

#include <atomic>

namespace stillgrid {

/// True once SIGINT, SIGTERM or SIGHUP came. install_stop_signal() once per process, before
/// threads.
[[nodiscard]] const std::atomic<bool>& stop_requested() noexcept;
void install_stop_signal();

/// The same for every other signal that ends a program and may be heeded, as SIGQUIT, SIGALRM or
/// SIGXCPU, where nobody has seen to it yet. Once per process, before threads.
void install_rare_stop_signals();

/// Which of those rare ones came first; 0 when none did.
[[nodiscard]] int rare_stop_signal() noexcept;

}  // namespace stillgrid
