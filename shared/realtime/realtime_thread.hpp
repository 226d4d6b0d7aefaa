#pragma once

#include <optional>
#include <string>
#include <vector>

namespace stillgrid::realtime {

/// Makes the calling thread real-time: SCHED_FIFO at priority 80, memory locked, 256 KiB of its
/// stack there, pinned to cpu if given. Threads that it starts are not.
///
/// Returns what could not be had, each as a short phrase with the cure; the thread runs on without
/// it.
[[nodiscard]] std::vector<std::string> make_realtime(std::optional<int> cpu);

/// Pins the calling thread; false if there is no such processor for us.
[[nodiscard]] bool pin_to_cpu(int cpu);

/// Page faults of the calling thread so far, minor and major.
[[nodiscard]] long page_faults();

}  // namespace stillgrid::realtime
