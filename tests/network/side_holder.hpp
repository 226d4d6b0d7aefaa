#pragma once

#include <sys/types.h>

#include "tests/network/network_side.hpp"

namespace stillgrid::network {

/// Starts a side's holder: a process in this one's network namespace, with a /dev/shm and a
/// monotonic clock of its own. It stays until the lifeline is cut, by the end of this process too,
/// and then kills every process of the network namespace. Throws NotGranted. Pre: one thread.
[[nodiscard]] pid_t start_holder(double clock_offset_s, const Lifeline& lifeline);

}  // namespace stillgrid::network
