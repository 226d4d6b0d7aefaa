#pragma once

#include <vector>

#include "shared/display/transition.hpp"

/// How a body is displayed between its snapshots, tick by tick, at regular periods.
namespace stillgrid::laboratory::two_rate {

/// The haptic period T; all times of the analysis are whole ticks of it.
inline constexpr double kTick_s = 1e-3;

/// What each tick of a period displays, from the first that shows a snapshot to the last before the
/// next one comes.
using Cycle = std::vector<display::SnapshotWeights>;

/// That of the product's transition, for snapshots of the state at their sample's time that come
/// `latency_ticks` after it.
[[nodiscard]] Cycle cycle_of(display::Transition transition, int period_ticks, int latency_ticks);

}  // namespace stillgrid::laboratory::two_rate
