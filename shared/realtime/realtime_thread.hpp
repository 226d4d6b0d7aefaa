#pragma once

namespace stillgrid::realtime {

/// Pins the calling thread; false if there is no such processor for us.
[[nodiscard]] bool pin_to_cpu(int cpu);

/// Page faults of the calling thread so far, minor and major.
[[nodiscard]] long page_faults();

}  // namespace stillgrid::realtime
