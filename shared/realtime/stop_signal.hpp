#pragma once

#include <atomic>

namespace stillgrid {

/// True once SIGINT, SIGTERM or SIGHUP came. install_stop_signal() once per process, before
/// threads.
[[nodiscard]] const std::atomic<bool>& stop_requested() noexcept;
void install_stop_signal();

}  // namespace stillgrid
