#pragma once

#include "tests/soak/soak_state.hpp"

namespace stillgrid::soak {

/// The writer's process: publishes the plan's snapshots, or goes on until it is killed; then keeps
/// its segment until it may end. Throws SegmentError.
void write_snapshots(const SoakPlan& plan, SoakState& state);

/// The reader's process: at 1 kHz in real time, or without rest beside a writer at full speed.
/// Attaches as the servers do, with housekeeping in a thread of its own. Ends when it has read the
/// plan's last snapshot, or when it may end.
void read_snapshots(const SoakPlan& plan, SoakState& state);

}  // namespace stillgrid::soak
